"""Both ends as LeRobot's classes: how they are found, what they refuse, and how they let go. Over loopback, in real time."""

import gc
import subprocess
import sys
import time

import cohold
import lerobot_robot_haptic
import lerobot_teleoperator_haptic
import numpy as np
import pytest
from lerobot.cameras import Camera, CameraConfig
from lerobot.robots import RobotConfig, make_robot_from_config
from lerobot.teleoperators import TeleoperatorConfig, make_teleoperator_from_config
from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError
from lerobot_robot_haptic import HapticFollower, HapticFollowerConfig
from lerobot_teleoperator_haptic import HapticLeader, HapticLeaderConfig

# A light pair with hands that damp, and nobody who does anything.
SCENE = {"scene": "any-network", "settings": {"device.damping_n_s_per_m": 5.0}}


def until(is_so, timeout_s=20.0):
    by = time.monotonic() + timeout_s
    while not is_so():
        assert time.monotonic() < by, "it did not come to that"
        time.sleep(0.01)


@pytest.fixture(name="both")
def _both(line):
    """Leader and follower, connected in the order of LeRobot's loops."""
    leader = HapticLeader(HapticLeaderConfig(**line[0], **SCENE))
    follower = HapticFollower(HapticFollowerConfig(**line[1], **SCENE))
    leader.connect()
    follower.connect()
    yield leader, follower
    for end in (leader, follower):
        if end.is_connected:
            end.disconnect()


def test_lerobot_finds_both():
    """By their names alone (conftest.py has it look), under the types that they say; and makes them as it makes its own."""
    assert RobotConfig.get_known_choices()["haptic_follower"] is HapticFollowerConfig
    assert TeleoperatorConfig.get_known_choices()["haptic_leader"] is HapticLeaderConfig
    assert isinstance(make_robot_from_config(HapticFollowerConfig()), HapticFollower)
    assert isinstance(make_teleoperator_from_config(HapticLeaderConfig()), HapticLeader)
    for package in (lerobot_robot_haptic, lerobot_teleoperator_haptic):
        assert "site-packages" in package.__file__, "it is the installed one that is tested"


@pytest.mark.parametrize("scene, axes", [("any-network", "x"), ("plane", "xy")])
def test_the_keys_are_those_of_the_shared_axes(scene, axes):
    follower = HapticFollower(HapticFollowerConfig(scene=scene))
    leader = HapticLeader(HapticLeaderConfig(scene=scene))
    seen = [f"{axis}.{word}" for word in ("pos", "vel", "force") for axis in axes]
    assert list(follower.observation_features) == [*seen, "time_s"]
    assert list(follower.action_features) == [f"{axis}.{word}" for word in ("pos", "force") for axis in axes]
    assert leader.action_features == follower.action_features and leader.feedback_features == {}


def test_the_leader_feels_what_pushes_the_follower(both):
    """At rest the same force at both ends; readings have the keys that they said, and go on."""
    leader, follower = both
    observation, action = follower.get_observation(), leader.get_action()
    assert set(observation) == set(follower.observation_features) and set(action) == set(leader.action_features)
    assert follower.send_action(action) == action
    follower.end.held().push(-1.0)
    leader.end.held().push(1.0)
    time.sleep(3.0)
    later, action = follower.get_observation(), leader.get_action()
    assert later["time_s"] > observation["time_s"] + 2.5
    assert action["x.force"] == pytest.approx(-1.0, abs=0.15)
    assert later["x.force"] == pytest.approx(1.0, abs=0.15)


def test_disconnect_lets_go_and_tells_the_other_end(both):
    leader, follower = both
    follower.get_observation()
    leader.end.held().push(2.0)
    until(lambda: leader.get_action()["x.force"] < -0.5)
    peer = follower.end.held()
    follower.disconnect()
    assert not follower.is_connected and not peer.running
    # The other end's copy is pushed by nothing any more.
    until(lambda: abs(leader.end.held().state.coordination_force_n) < 1e-6, 3.0)
    with pytest.raises(DeviceNotConnectedError, match="not connected"):
        follower.get_observation()
    with pytest.raises(DeviceNotConnectedError):
        follower.disconnect()


def test_a_fault_is_raised_in_words_and_connecting_begins_anew(both, line):
    leader, follower = both
    follower.get_observation()
    # A hand that is torn away: faster than its peer allows.
    leader.end.held().push(1000.0)

    def reads_on():
        while True:
            leader.get_action()
            time.sleep(0.005)

    with pytest.raises(DeviceNotConnectedError, match="its motors are off: fault"):
        reads_on()
    # It still holds its peer, so that the loop's own end disconnects it.
    assert leader.is_connected and leader.end.held().state.force_n == 0.0
    leader.disconnect()
    leader.connect()
    assert leader.get_action()["x.force"] == pytest.approx(0.0, abs=1.0)


def test_a_leader_that_is_far_is_what_the_followers_peer_knows(line):
    far = HapticLeader(HapticLeaderConfig(at="far", **{key: SCENE[key] for key in ("scene", "settings")}))
    far.connect()
    with pytest.raises(DeviceNotConnectedError, match="and 0 are connected"):
        far.get_action()
    follower = HapticFollower(HapticFollowerConfig(**line[1], **SCENE))
    with cohold.LivePeer("any-network", 1, settings=SCENE["settings"], **line[0]) as leader, follower:
        follower.end.state()
        leader.push(1.0)
        follower.end.held().push(-1.0)
        time.sleep(3.0)
        action, state = far.get_action(), leader.state
        assert action["x.pos"] == pytest.approx(state.object_m, abs=1e-3)
        assert action["x.force"] == pytest.approx(state.force_n, abs=0.15)
        leader.close()

        def reads_on():
            by = time.monotonic() + 5.0
            while time.monotonic() < by:
                far.get_action()
                time.sleep(0.01)

        with pytest.raises(DeviceNotConnectedError, match="is gone: nothing has come from"):
            reads_on()
    far.disconnect()
    assert not far.is_connected


def test_led_by_actions_it_goes_there_without_a_jump(tmp_path):
    """No faster than a hand goes, and as far as it was told; what is no place is refused, and moves nothing."""
    follower = HapticFollower(HapticFollowerConfig(led_by="actions", scene="leader-follower"))
    with follower:
        start = follower.get_observation()["x.pos"]
        for wrong, says in (({}, "the action has no x.pos"), ({"x.pos": float("nan")}, "x.pos = nan is not allowed")):
            with pytest.raises(ValueError, match=says):
                follower.send_action(wrong)
        seen = []
        by = time.monotonic() + 8.0
        while time.monotonic() < by:
            follower.send_action({"x.pos": start + 0.05, "x.force": 0.0})
            seen.append(follower.get_observation()["x.pos"])
            time.sleep(1 / 60)
        assert np.abs(np.diff(seen)).max() < 0.02
        assert seen[-1] == pytest.approx(start + 0.05, abs=0.01)
        leader = follower.leader
    assert follower.leader is None and leader is not None and not leader.running


def test_who_holds_nothing_and_who_is_not_there(line):
    leader = HapticLeader(HapticLeaderConfig(**line[0], **SCENE, wait_s=0.5))
    for call in (leader.get_action, leader.disconnect):
        with pytest.raises(DeviceNotConnectedError):
            call()
    leader.connect()
    with pytest.raises(DeviceAlreadyConnectedError, match="connected already"):
        leader.connect()
    with pytest.raises(DeviceNotConnectedError, match=f"nobody answered from {line[0]['connect']} within 0.5 s"):
        leader.get_action()
    leader.disconnect()


def test_an_end_that_is_dropped_lets_go(line):
    """LeRobot's own destructor disconnects; its socket is free again."""
    leader = HapticLeader(HapticLeaderConfig(**line[0], **SCENE))
    leader.connect()
    del leader
    gc.collect()
    again = HapticLeader(HapticLeaderConfig(**line[0], **SCENE))
    again.connect()
    again.disconnect()


@pytest.mark.parametrize(
    "make, match",
    [
        (lambda: HapticFollowerConfig(led_by="me"), 'led_by = "me" is not allowed: it must be "wire" or "actions"'),
        (lambda: HapticLeaderConfig(at="home"), 'at = "home" is not allowed: it must be "here" or "far"'),
        (lambda: HapticLeader(HapticLeaderConfig(settings={"object.mass_kg": -1})), "object.mass_kg = -1 is not allowed"),
    ],
)
def test_refusals(make, match):
    with pytest.raises(ValueError, match=match):
        make()


def test_what_cannot_be_opened_is_not_connected(line):
    follower = HapticFollower(HapticFollowerConfig(**{**line[1], "listen": "here"}, **SCENE))
    with pytest.raises(ValueError, match='listen = "here" is not allowed'):
        follower.connect()
    assert not follower.is_connected


@CameraConfig.register_subclass("test_pattern")
class PatternConfig(CameraConfig):
    pass


class Pattern(Camera):
    """A picture of one colour, without a device."""

    is_connected = False

    @staticmethod
    def find_cameras():
        return []

    def connect(self, warmup=True):
        self.is_connected = True

    def read(self, color_mode=None):
        return np.full((self.height, self.width, 3), 7, dtype=np.uint8)

    async_read = read_latest = read

    def disconnect(self):
        self.is_connected = False


def test_cameras_are_lerobots_own(line):
    pattern = PatternConfig(fps=30, width=8, height=6)
    follower = HapticFollower(HapticFollowerConfig(led_by="actions", **SCENE, cameras={"wrist": pattern}))
    assert follower.observation_features["wrist"] == (6, 8, 3)
    with follower:
        assert follower.get_observation()["wrist"].shape == (6, 8, 3)
        camera = follower.cameras["wrist"]
    assert not camera.is_connected


def test_types_pass_mypy():
    """Of both packages as they are installed; LeRobot says no types of its own."""
    words = ["--strict", "--disable-error-code=import-untyped", "--disable-error-code=misc", "--follow-imports=silent"]
    packages = ["-p", "lerobot_robot_haptic", "-p", "lerobot_teleoperator_haptic"]
    done = subprocess.run([sys.executable, "-m", "mypy", *words, *packages], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
