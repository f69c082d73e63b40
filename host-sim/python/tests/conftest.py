"""What the tests share: the command line, whose word on every bit is what the module is held to."""

import json
import os
import subprocess

import pytest


def command_line(*arguments: object, fails: bool = False) -> dict:
    """What `cohold … --json` says, be it good (exit status 0) or not (1), or, of one that cannot be done (2), its line."""
    command = [os.environ["COHOLD"], *map(str, arguments), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode in ([2] if fails else [0, 1]), done.stderr
    return {"error": done.stderr.strip()} if fails else json.loads(done.stdout)


@pytest.fixture(name="command_line")
def _command_line():
    return command_line
