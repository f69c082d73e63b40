"""What people expect of a Python package: notebooks, progress, tables of other libraries with units."""

import json
import subprocess
import sys

import cohold
import numpy as np
import pytest


def test_notebooks_show_a_table():
    scene = cohold.Scene("paper-5.1-power-16ms", {"coordination.stiffness_n_per_m": 20_000})
    run, judged = cohold.run(scene, 1.0), cohold.stability(scene)
    shown = run._repr_html_()
    assert shown.startswith("<table>") and f"<td>{run.verdict}</td>" in shown and run.state_hash in shown
    assert all(f"<th>{name}</th>" in shown for name in run.merits)
    assert f"{judged.modes['both']:.9f}" in judged._repr_html_() and "<td>NO</td>" in judged._repr_html_()


def test_long_calls_tell_how_far_they_are():
    told = []
    run = cohold.run(cohold.Scene("matched-line"), 600.0, every=0, progress=lambda *so: told.append(so))
    assert told[-1] == (run.ticks, 600_000) and len(told) > 1
    assert [done for done, _ in told] == sorted(done for done, _ in told)
    told.clear()
    sweep = cohold.Sweep("matched-line", {"network.loss": "0..0.5:20"}, seeds=4, seconds=20.0)
    sweep.run(progress=lambda *so: told.append(so))
    assert told[-1] == (80, 80) and told[0][0] > 0


def test_what_progress_raises_ends_the_call():
    def enough(done, total):
        raise KeyError(f"{done} of {total}")

    with pytest.raises(KeyError, match="of 3600000"):
        cohold.run(cohold.Scene("matched-line"), 3600.0, every=0, progress=enough)


def test_units_are_the_ends_of_names():
    assert cohold.unit("object_1_m") == "m" and cohold.unit("coordination_force_mean_n") == "N"
    assert cohold.unit("stable") == "" and cohold.unit("true_discrepancy_mm") == "mm"


def test_pandas_and_xarray_have_units():
    pytest.importorskip("xarray")
    run = cohold.run(cohold.Scene("matched-line"), 1.0)
    frame, data = cohold.to_pandas(run), cohold.to_xarray(run)
    assert frame.attrs["units"]["object_1_m"] == "m" and list(frame) == list(run.columns)
    assert data["object_1_m"].dims == ("time",) and data["object_1_m"].attrs["units"] == "m"
    assert data["time"].attrs["units"] == "s" and data.attrs["state_hash"] == run.state_hash
    for name in data:
        assert np.array_equal(data[name].values, run.columns[name]), name
    assert float(data["object_1_m"].sel(time=0.5, method="nearest")) == run.columns["object_1_m"][500]
    space = cohold.run(cohold.Scene("space"), 0.2)
    data = cohold.to_xarray(space)
    assert data["object_1_m"].dims == ("axis", "time") and list(data["axis"].values) == ["x", "y", "z"]
    assert np.array_equal(data["object_1_m"].sel(axis="z").values, space.axes[2]["object_1_m"])
    assert np.array_equal(cohold.to_pandas(space)["y"]["object_1_m"], space.axes[1]["object_1_m"])
    table = cohold.Sweep("matched-line", {"network.loss": [0.0, 0.1]}, seconds=1.0).run()
    data = cohold.to_xarray(table)
    assert data.sizes == {"run": 2} and data["true_discrepancy_mm"].attrs["units"] == "mm"
    assert data["stable"].dtype == bool


def test_neither_is_needed_to_import():
    code = "import json, sys, cohold; print(json.dumps([m for m in ('pandas', 'xarray') if m in sys.modules]))"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert json.loads(said) == []
