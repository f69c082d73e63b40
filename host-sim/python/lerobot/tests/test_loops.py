"""LeRobot's own programs with both plugins: over loopback, in real time; a leader that presses a follower against a wall, simulated at both ends."""

import os
import subprocess

import lerobot.scripts.lerobot_record as lerobot_record
import lerobot.scripts.lerobot_replay as lerobot_replay
import lerobot.scripts.lerobot_teleoperate as lerobot_teleoperate
import numpy as np
import pytest
from conftest import flags, ticks
from lerobot.datasets import LeRobotDataset

# The leader reaches 0.1 m of the world within 2 s; there is a wall at 0.05 m.
SCENE = {"scene": "leader-follower-wall", "settings": "{user.1.reach_m: 0.02, user.1.reach_s: 2.0}"}
WALL_M = 0.05
# Of the hand that replays, at the leader's device, whose places and forces are scaled alike.
HAND_N_PER_M = 200.0
FPS, SECONDS = 60, 6


def column(dataset, feature, name):
    names = dataset.features[feature]["names"]
    return np.array([row[names.index(name)] for row in dataset.hf_dataset.with_format(None)[feature]])


def at_the_end(numbers):
    return float(np.mean(numbers[-FPS // 2 :]))


def test_teleoperate_takes_the_follower_to_the_wall(line, tmp_path, program):
    """Its loop runs as it is, by the types that it found; what the peers recorded at 1 kHz shows the follower moved, and pushed back."""
    kept = [tmp_path / "leader.mcap", tmp_path / "follower.mcap"]
    program(
        lerobot_teleoperate,
        *flags("teleop", {"type": "haptic_leader", **line[0], **SCENE, "record": kept[0]}),
        *flags("robot", {"type": "haptic_follower", **line[1], **SCENE, "record": kept[1]}),
        f"--fps={FPS}",
        f"--teleop_time_s={SECONDS}",
    )
    leader, follower = map(ticks, kept)
    for table in (leader, follower):
        assert (table["mode"] == 1).sum() > 900 * (SECONDS - 1) and not table["fault"].any()
    armed = [table[table["mode"] == 1] for table in (leader, follower)]
    assert armed[1]["device_m"].iloc[-500:].mean() > WALL_M
    # The same at both ends, as statics have it.
    pushed = [table["contact_n"].iloc[-500:].mean() for table in armed]
    assert pushed[0] > 2.0 and pushed[1] == pytest.approx(-pushed[0], rel=0.1)


def test_a_leader_at_another_machine_is_recorded_by_what_came_of_it(line, tmp_path, program):
    """The page's two machines, on loopback: `cohold peer` with the leader, LeRobot with the follower alone."""
    words = ["--number", 1, "--listen", line[0]["listen"], "--connect", line[0]["connect"], "--key-file", line[0]["key"]]
    words += ["--scene", "leader-follower", "--seconds", 60, "--json"]
    with subprocess.Popen([os.environ["COHOLD"], "peer", *map(str, words)], stdout=subprocess.DEVNULL) as leader:
        try:
            program(
                lerobot_record,
                *flags("teleop", {"type": "haptic_leader", "at": "far"}),
                *flags("robot", {"type": "haptic_follower", **line[1]}),
                *flags("dataset", {"repo_id": "lab/far", "root": tmp_path / "set", "fps": FPS, "num_episodes": 1}),
                *flags("dataset", {"episode_time_s": 4, "single_task": "Reach out", "push_to_hub": "false", "no_stamp": "true"}),
                "--play_sounds=false",
            )
        finally:
            leader.kill()
    dataset = LeRobotDataset("lab/far", root=tmp_path / "set")
    # It reaches 0.1 m, and the follower with it, some milliseconds later.
    led, followed = column(dataset, "action", "x.pos"), column(dataset, "observation.state", "x.pos")
    assert led[0] < 0.02 and at_the_end(led) == pytest.approx(0.1, abs=0.02)
    assert at_the_end(followed) == pytest.approx(at_the_end(led), abs=0.01)


def test_a_data_set_is_what_the_peers_recorded(line, tmp_path, program):
    """Recorded by LeRobot and read back by it; then replayed, without the leader."""
    kept, root = [tmp_path / "leader.mcap", tmp_path / "follower.mcap"], tmp_path / "set"
    program(
        lerobot_record,
        *flags("teleop", {"type": "haptic_leader", **line[0], **SCENE, "record": kept[0]}),
        *flags("robot", {"type": "haptic_follower", **line[1], **SCENE, "record": kept[1]}),
        *flags("dataset", {"repo_id": "lab/wall", "root": root, "fps": FPS, "num_episodes": 1, "episode_time_s": SECONDS}),
        *flags("dataset", {"single_task": "Press on the wall", "push_to_hub": "false", "no_stamp": "true"}),
        "--play_sounds=false",
    )
    dataset = LeRobotDataset("lab/wall", root=root)
    assert dataset.num_frames > 0.8 * FPS * SECONDS and dataset.fps == FPS
    leader, follower = map(ticks, kept)

    # Each frame is a tick of the follower's own recording, by its time: places, speeds and forces.
    times = column(dataset, "observation.state", "time_s")
    seen = follower.iloc[[int(np.abs(follower["time_s"] - time).argmin()) for time in times]]
    # As near as the data set's own numbers are: single precision, 0.5 µs at 8 s.
    assert np.abs(seen["time_s"].to_numpy() - times).max() < 1e-6
    for name, kept_name in (("x.pos", "device_m"), ("x.vel", "device_m_per_s")):
        assert column(dataset, "observation.state", name) == pytest.approx(seen[kept_name].to_numpy(), abs=1e-7), name
    force = column(dataset, "observation.state", "x.force")
    assert force == pytest.approx(-seen["contact_n"].to_numpy(), abs=1e-5)

    # Each action is a tick of the leader's: places there are in the order of ticks, some 17 ms apart.
    place = column(dataset, "action", "x.pos")
    moving = np.flatnonzero(np.abs(np.diff(place)) > 1e-5)
    found = [np.flatnonzero(leader["device_m"].to_numpy(dtype=np.float32) == np.float32(place[frame])) for frame in moving]
    assert len(moving) > FPS and all(len(ticks) for ticks in found)
    assert (np.diff([ticks[0] for ticks in found]) > 0).mean() > 0.9
    # What the follower meets is what the leader feels, at rest.
    felt = column(dataset, "action", "x.force")
    assert at_the_end(force) > 1.0
    assert at_the_end(felt) == pytest.approx(-at_the_end(force), rel=0.1)

    # The follower alone, led by what was recorded.
    again = tmp_path / "again.mcap"
    program(
        lerobot_replay,
        *flags("robot", {"type": "haptic_follower", **SCENE, "led_by": "actions", "record": again}),
        *flags("dataset", {"repo_id": "lab/wall", "root": root, "episode": 0}),
        "--play_sounds=false",
    )
    replayed = ticks(again)
    assert not replayed["fault"].any()
    moved = replayed[replayed["mode"] == 1].iloc[-500:]
    # It comes back to the wall. What is between leader and wall is a spring of F over its way there; the replaying hand is one more behind it.
    assert moved["device_m"].mean() == pytest.approx(at_the_end(column(dataset, "observation.state", "x.pos")), abs=3e-3)
    line_n_per_m = at_the_end(force) / (at_the_end(column(dataset, "action", "x.pos")) - WALL_M)
    pressed = at_the_end(force) * HAND_N_PER_M / (HAND_N_PER_M + line_n_per_m)
    assert -moved["contact_n"].mean() == pytest.approx(pressed, rel=0.2)
    # The figures of docs/guides/lerobot.md, shown by `pytest -s`.
    at = [at_the_end(column(dataset, "observation.state", "x.pos")), moved["device_m"].mean()]
    forces = [at_the_end(force), -at_the_end(felt), -moved["contact_n"].mean(), pressed]
    print(f"frames {dataset.num_frames}; met, felt, replayed, as statics have it: {forces} N; recorded, replayed at {at} m")
