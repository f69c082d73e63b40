"""A live peer from Python with a device that the command line emulates, as whoever has no device would try one."""

import json
import os
import signal
import subprocess
import time

import cohold
import pytest
from test_live import _line, until  # noqa: F401


@pytest.fixture(name="inverse3")
def _inverse3():
    """An emulated Inverse3 whose hand reaches 20 mm, and which falls silent 16 s after it was started; the words that attach it."""
    command = [os.environ["COHOLD"], "--json", "devices", "emulate", "inverse3", "--at", "127.0.0.1:0"]
    command += ["--set", "user.1.reach_m=0.02", "--rest-s", "4", "--fault", "silent@16", "--lets-go-s", "0.2", "--seconds", "120"]
    emulator = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert emulator.stderr is not None
        words = next(line.split() for line in emulator.stderr if line.lstrip().startswith("--device "))
        yield emulator, dict(zip(words[::2], words[1::2]))
    finally:
        emulator.kill()
        emulator.wait()


def test_an_emulated_device_is_held_until_it_falls_silent(line, inverse3):
    emulator, words = inverse3
    # Both run on this machine, beside other tests.
    silent_s = 0.2
    device = {"device": words["--device"], "device_lets_go_s": float(words["--device-lets-go-s"]), "device_silent_s": silent_s}
    # The other hand holds on.
    holds = {"user.2.arm_stiffness_n_per_m": 300.0, "user.2.arm_damping_n_s_per_m": 8.0}
    with (
        cohold.LivePeer("any-network", 1, settings=holds, **device, **line[0]) as one,
        cohold.LivePeer("any-network", 2, settings=holds, **line[1]) as two,
    ):
        assert one.wait_armed(20) and two.wait_armed(20)
        # Two hands of 300 N/m and two contacts of 1000 N/m in a row would be 2.3 N at rest.
        until(lambda: one.state.force_n < -1.0 and two.state.force_n > 1.0)
        assert one.state.hand_m > 0.003 and one.state.mode == "armed"
        until(lambda: one.state.fault is not None or not one.running)
        assert one.state.force_n == 0.0
        assert one.wait(5.0)
        report, other = one.report, two.stop()["other"]
    assert other["state"].startswith("fault 23: ")
    assert report["fault"].startswith("fault 23: ") and report["device"]["name"] == "Inverse3 049D"
    time.sleep(0.1)
    emulator.send_signal(signal.SIGINT)
    seen = json.loads(emulator.communicate(timeout=10)[0])
    assert emulator.returncode == 0
    (planted,) = seen["faults"]
    assert planted["fault"] == "silent" and 0.0 <= (planted["last_push_after_s"] or 0.0) < silent_s + 0.1
    assert seen["force_n"] == [0.0, 0.0, 0.0] and seen["orders"] > 5_000
