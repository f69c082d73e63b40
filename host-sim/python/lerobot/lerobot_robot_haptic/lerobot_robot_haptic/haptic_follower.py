"""The follower's end of a haptic line as a robot of LeRobot's.

Who moves it is the leader, over the wire and 1000 times a second; LeRobot reads what it does, as often as its loop goes. Without a leader
(`led_by="actions"`: replay, or a policy) a simulated one is held here, whose hand goes where the actions say: the follower is moved through the
same line, law and guards, and whatever its device is.
"""

from __future__ import annotations

import pathlib
import socket
import tempfile
from functools import cached_property
from typing import Any

import cohold
from lerobot.cameras import make_cameras_from_configs
from lerobot.robots import Robot

from .config_haptic_follower import HapticFollowerConfig
from .end import AXES, End, along, places

# What a simulated user of the scene does is not done by a leader whose hand is moved.
_NOTHING = ("push_n", "pulse_n", "sine_n", "side_push_n", "arm_stiffness_n_per_m", "arm_damping_n_s_per_m", "clutch_for_s")


def _free_addresses() -> list[str]:
    """Two addresses on loopback that nobody has."""
    sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    found = [f"127.0.0.1:{one.getsockname()[1]}" for one in sockets]
    for one in sockets:
        one.close()
    return found


class HapticFollower(Robot):
    """Peer 2 of a haptic scene. Observations along each shared axis: `x.pos` (m) and `x.vel` (m/s) of its hand, and `x.force` (N), with which
    its motors push that hand, all of the shared world; `time_s` is the tick's own time, as in the recording at 1 kHz. Actions: `x.pos` (m) and
    `x.force` (N) of the leader's hand.
    """

    config_class = HapticFollowerConfig
    name = "haptic_follower"

    def __init__(self, config: HapticFollowerConfig) -> None:
        super().__init__(config)
        self.config = config
        self.end = End(config, f"{self.name} {config.id}" if config.id else self.name)
        # Who leads it in a replay.
        self.leader: cohold.LivePeer | None = None
        # Metres of the world to a metre of that leader's device.
        self._leader_scale = 1.0
        self.cameras = make_cameras_from_configs(config.cameras)

    @cached_property
    def observation_features(self) -> dict[str, Any]:
        axes = AXES[: self.end.axes]
        state = {f"{axis}.{word}": float for word in ("pos", "vel", "force") for axis in axes}
        images = {name: (camera.height, camera.width, 3) for name, camera in self.cameras.items()}
        return {**state, "time_s": float, **images}

    @cached_property
    def action_features(self) -> dict[str, Any]:
        return {f"{axis}.{word}": float for word in ("pos", "force") for axis in AXES[: self.end.axes]}

    @property
    def is_connected(self) -> bool:
        return self.end.peer is not None

    @property
    def is_calibrated(self) -> bool:
        return True

    def connect(self, calibrate: bool = True) -> None:
        """Holds the peer, and waits until both ends are armed: the leader is connected first, as LeRobot's programs do."""
        try:
            if self.config.led_by == "actions":
                self._open_led()
            else:
                self.end.open(2)
            for camera in self.cameras.values():
                camera.connect()
            self.end.state()
        except BaseException:
            if self.is_connected:
                self.disconnect()
            raise
        End.of_robots.append(self.end)
        self.configure()

    def _open_led(self) -> None:
        here, there = _free_addresses()
        with tempfile.TemporaryDirectory() as folder:
            key = pathlib.Path(folder) / "replay.key"
            cohold.generate_key(key)
            self.end.open(2, listen=here, connect=there, key=key)
            users_own = {f"user.1.{does}": 0.0 for does in _NOTHING}
            scene = cohold.Scene(self.config.scene, {**self.config.settings, **users_own})
            self._leader_scale = float(scene["peer.1.scale.position"])
            self.leader = cohold.LivePeer(
                scene, 1, listen=there, connect=here, key=key, patience_s=self.config.wait_s
            )

    def calibrate(self) -> None:
        """Nothing to do: a device is homed before it is armed, and says so itself."""

    def configure(self) -> None:
        """Nothing to do: the scene is what it is told, and both ends compare it before they arm."""

    def get_observation(self) -> dict[str, Any]:
        state, axes = self.end.state(), self.end.axes
        seen: dict[str, Any] = {
            **along(axes, state.hand_m, "pos"),
            **along(axes, state.hand_m_per_s, "vel"),
            **along(axes, state.force_n, "force"),
            "time_s": state.time_s,
        }
        for name, camera in self.cameras.items():
            seen[name] = camera.read_latest()
        return seen

    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        """Led by the wire this changes nothing: it has been done by then. Led by actions it takes the leader's hand there."""
        self.end.state()
        wanted = places(self.end.axes, action)
        if self.leader is not None:
            own = [place / self._leader_scale for place in wanted]
            self.leader.move_hand(own[0] if len(own) == 1 else own)
        return action

    def disconnect(self) -> None:
        """Turns the motors off, tells the other end, and lets go."""
        self.end.held()
        if self.end in End.of_robots:
            End.of_robots.remove(self.end)
        try:
            self.end.close()
        finally:
            leader, self.leader = self.leader, None
            if leader is not None:
                leader.close()
            for camera in self.cameras.values():
                if camera.is_connected:
                    camera.disconnect()
