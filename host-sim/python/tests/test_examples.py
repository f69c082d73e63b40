"""The examples run, and say what they promise."""

import pathlib
import re
import subprocess
import sys

EXAMPLES = pathlib.Path(__file__).parents[1] / "examples"


def said(name: str, folder: pathlib.Path, *arguments: str) -> str:
    command = [sys.executable, EXAMPLES / f"{name}.py", *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, check=True).stdout


def test_figure(tmp_path, command_line):
    told = said("figure", tmp_path, "figure.pdf")
    assert (tmp_path / "figure.pdf").read_bytes().startswith(b"%PDF")
    for comm in ("power", "wave", "passive-wave"):
        run = command_line("cooperate", "--scene", f"paper-5.2-{comm}-16ms")
        assert run["state_hash"] in told and f"decoded {run['decoded_discrepancy_mm']:.3f} mm" in told


def test_bursts(tmp_path):
    lines = [line for line in said("bursts", tmp_path, "5").splitlines() if line.startswith("bursts of")]
    assert len(lines) == 12
    assert sum("±" in line for line in lines) >= 4 and any("rest" in line and "±" in line for line in lines)


def test_own_user(tmp_path):
    places = [float(place) for place in re.findall(r"is at (\S+) mm", said("own_user", tmp_path))]
    assert len(places) == 2 and all(abs(place - 30.0) < 3.0 for place in places)


def test_mujoco_device(tmp_path):
    """Where statics say: 1 N from each side, a contact of 1000 N/m, copies less than a millimetre apart."""
    told = said("mujoco_device", tmp_path)
    objects, handles = ([float(x) for x in re.findall(rf"{what} at (\S+) mm", told)] for what in ("object", "handle"))
    contact_mm = 1e3 / 1000.0
    for sign, held, hand in zip((1.0, -1.0), objects, handles):
        assert abs(sign * (hand - held) - contact_mm) < 0.01
    (apart,) = re.findall(r"apart: (\S+) mm", told)
    assert float(apart) < 1.0


def test_carry(tmp_path):
    told = said("carry", tmp_path, "0.2")
    rewards = dict(re.findall(r"(\w+) +(-\S+) m, summed", told))
    assert float(rewards["steering"]) > 0.5 * float(rewards["steady"])
    assert [line.split()[0] for line in told.splitlines()[3:]] == ["1", "16", "256"]
