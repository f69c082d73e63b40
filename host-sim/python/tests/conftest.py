"""What the tests share: the command line, whose word on every bit is what the module is held to."""

import json
import os
import subprocess

import pytest


def host_sim(*arguments: object, fails: bool = False) -> dict:
    """What `host-sim … --json` says, or, of one that fails, its line."""
    command = [os.environ["HOST_SIM"], *map(str, arguments), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert (done.returncode != 0) == fails, done.stderr
    return {"error": done.stderr.strip()} if fails else json.loads(done.stdout)


@pytest.fixture(name="host_sim")
def _host_sim():
    return host_sim
