"""What the tests share: LeRobot with stand-ins for its heaviest libraries, a folder of its own for what it keeps, and a line on loopback."""

import os
import socket
import subprocess
import sys
import tempfile

import stand_ins

stand_ins.install()
# Before LeRobot is imported: it writes calibrations and looks for data sets there, and nowhere else.
_home = tempfile.TemporaryDirectory(prefix="lerobot-")
os.environ.update(HF_HOME=_home.name, HF_LEROBOT_HOME=f"{_home.name}/lerobot", HF_HUB_OFFLINE="1")

import cohold  # noqa: E402
import pandas  # noqa: E402
import pytest  # noqa: E402
from lerobot.utils.import_utils import register_third_party_plugins  # noqa: E402

register_third_party_plugins()


@pytest.fixture(name="line")
def _line(tmp_path):
    """What the two ends of a line are told: the leader's, then the follower's."""
    key = tmp_path / "pair.key"
    cohold.generate_key(key)
    sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    one, two = ("127.0.0.1:{}".format(one.getsockname()[1]) for one in sockets)
    for each in sockets:
        each.close()
    return {"listen": one, "connect": two, "key": str(key)}, {"listen": two, "connect": one, "key": str(key)}


def flags(of, settings):
    """As the command line of a LeRobot program has them."""
    return [f"--{of}.{key}={value}" for key, value in settings.items()]


@pytest.fixture(name="program")
def _program(monkeypatch):
    """Runs a program of LeRobot's as it stands, with the command line's own words."""

    def program(module, *words):
        monkeypatch.setattr(sys, "argv", [module.__name__, *map(str, words)])
        module.main()

    return program


def ticks(recording):
    """The ticks of a recording at 1 kHz, as the command line converts them."""
    table = recording.with_suffix(".parquet")
    command = [os.environ["COHOLD"], "recording", "convert", str(recording), str(table), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return pandas.read_parquet(table)
