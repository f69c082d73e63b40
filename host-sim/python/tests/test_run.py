"""Runs and verdicts: the command line's bits."""

import importlib.metadata
import pickle
import subprocess
import sys
import threading
import time

import cohold
import numpy as np
import pytest

SECONDS = 3.0
SCALARS = ["f32", "f64", "i32f32"]
# The command line is a debug build here, which takes a minute for each verdict on lines so long: these are compared in one scalar.
LONG_LINES = ["leader-follower", "leader-follower-wall"]


@pytest.mark.parametrize("name", cohold.scenes())
def test_every_built_in_scene_gives_the_command_lines_bits(name, command_line):
    scene = cohold.Scene(name)
    for scalar in SCALARS[:1] if name in LONG_LINES else SCALARS:
        run = cohold.run(scene, SECONDS, scalar, every=0)
        assert len(run.axes) == scene["axis.shared"] and run.axes[0].keys() == run.columns.keys()
        told = command_line("cooperate", "--scene", name, "--seconds", SECONDS, "--scalar", scalar)
        assert run.state_hash == told["state_hash"], scalar
        assert (run.stable, run.verdict, run.reason) == (told["stable"], told["verdict"], told["reason"])
        assert run.spectral_radius == told["spectral_radius"]
        assert "; ".join(run.unstable_modes) == (told["unstable_modes"] or "")
        assert run.ticks == told["ticks"]
        for merit in ["true_discrepancy_mm", "true_discrepancy_mm_per_n", "decoded_discrepancy_mm", "energy_made_mj"]:
            assert run.merits[merit] == told[merit], (scalar, merit)
        force = told["coordination_force_n"]
        assert (run.merits["coordination_force_mean_n"], run.merits["coordination_force_sd_n"]) == (force["mean"], force["sd"])
    judged, told = cohold.stability(scene), command_line("stability", "point", "--scene", name)
    assert (judged.stable, judged.spectral_radius) == (told["stable"], told["spectral_radius"])
    walls = {True: ", at the walls", None: ""}
    assert judged.modes == {mode["mode"] + walls[mode.get("at_walls")]: mode["spectral_radius"] for mode in told["modes"]}
    assert run.unstable_modes == [mode for mode, radius in judged.modes.items() if radius > 1 + 1e-9]
    assert judged.not_judged == told["not_judged"]
    assert cohold.advice(scene) == told["advice"]


def test_limits_are_the_command_lines(command_line):
    key = "coordination.stiffness_n_per_m"
    told = command_line("stability", "limit", "--scene", "paper-5.1-power-16ms", "--of", key, "--from", 10, "--to", 3000)
    found = cohold.limit(cohold.Scene("paper-5.1-power-16ms"), key, 10, 3000)
    assert found == told["crossings"] and len(found) == 1
    above, below = ({key: factor * found[0]} for factor in (1.001, 0.999))
    assert not cohold.stability(cohold.Scene("paper-5.1-power-16ms", above)).stable
    assert cohold.stability(cohold.Scene("paper-5.1-power-16ms", below)).stable


def test_what_was_computed_is_pickled():
    scene = cohold.Scene("plane")
    run, judged = cohold.run(scene, 0.5), cohold.stability(scene)
    other, again = pickle.loads(pickle.dumps((run, judged)))
    assert repr((other, again)) == repr((run, judged))
    for name in ("stable", "verdict", "reason", "fault", "fault_time_s", "spectral_radius", "unstable_modes", "ticks", "merits"):
        assert getattr(other, name) == getattr(run, name), name
    assert len(other.axes) == 2 and other.columns.keys() == run.columns.keys()
    for one, told in zip(other.axes, run.axes):
        assert all(np.array_equal(one[name], told[name]) for name in told)
    assert (again.stable, again.modes, again.not_judged) == (judged.stable, judged.modes, judged.not_judged)
    assert cohold.__version__ == importlib.metadata.version("cohold")


def test_a_faulted_run_has_a_reason_and_no_merits():
    scene = cohold.Scene("paper-5.1-power-16ms", {"coordination.stiffness_n_per_m": 20_000})
    run = cohold.run(scene, 4.0)
    assert not run.stable and run.verdict == "NO" and run.reason
    assert run.merits["coordination_force_mean_n"] is None
    assert run.fault is None or run.fault[0] in (1, 2) and 0 < run.fault_time_s < 4.0


def test_columns_are_the_simulators_own_memory():
    run = cohold.run(cohold.Scene("matched-line"), 2.0)
    assert len(run.columns) == 27 and all(len(column) == 2000 for column in run.columns.values())
    assert not any(column.flags.owndata for column in run.columns.values())
    apart = np.abs(run.columns["object_1_m"] - run.columns["object_2_m"])
    assert np.array_equal(apart, run.columns["true_discrepancy_m"])
    assert run.merits["true_discrepancy_mm"] == pytest.approx(1e3 * apart[1000:].mean(), rel=1e-12)
    tenth = cohold.run(cohold.Scene("matched-line"), 2.0, every=10)
    assert np.array_equal(tenth.columns["object_1_m"], run.columns["object_1_m"][::10])
    assert len(cohold.run(cohold.Scene("matched-line"), 2.0, every=0).columns["time_s"]) == 0


@pytest.mark.parametrize(
    "wrong, says",
    [
        ({"seconds": 0.0}, "seconds = 0 is not allowed: it must be a number from 0.001 (one control period) to 86400 s"),
        ({"seconds": float("nan")}, "seconds = NaN is not allowed"),
        ({"scalar": "f16"}, 'scalar = "f16" is not allowed: it must be one of "f32", "f64", "i32f32"'),
        ({"every": -1}, "every = -1 is not allowed"),
    ],
)
def test_what_cannot_be_run_is_refused(wrong, says):
    with pytest.raises(ValueError) as refused:
        cohold.run(cohold.Scene(), **wrong)
    assert says in str(refused.value)


@pytest.mark.parametrize("work", ["cohold.run(scene, 86_400.0, every=0)", "many.run()", "cohold.Pair(scene).steps(forces)", "cohold.Pair(plane).steps(along)"])
def test_ctrl_c_ends_whatever_takes_long(work):
    code = f"""
import os, signal, threading, time, cohold, numpy
scene = cohold.Scene("paper-5.2-passive-wave-16ms")
many = cohold.Sweep(scene, {{"network.loss": "0..0.5:20000"}})
forces = numpy.zeros((20_000_000, 2))
plane, along = cohold.Scene("plane"), numpy.broadcast_to(0.0, (20_000_000, 2, 2))
pressed = []
def press():
    time.sleep(0.5)
    pressed.append(time.perf_counter())
    os.kill(os.getpid(), signal.SIGINT)
threading.Thread(target=press).start()
try:
    {work}
except KeyboardInterrupt:
    print(time.perf_counter() - pressed[0])
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert float(done.stdout) < 1.0


def test_a_table_that_there_is_no_room_for_is_refused():
    with pytest.raises(ValueError, match="every = 1 is not allowed here: it makes 86400000 rows, and a table has at most 20000000"):
        cohold.run(cohold.Scene(), 86_400.0, every=1)


def test_other_threads_go_on_while_rust_works():
    ticks, stop = [0], threading.Event()

    def count():
        while not stop.is_set():
            ticks[0] += 1
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    counter.start()
    start = time.perf_counter()
    cohold.run(cohold.Scene("paper-5.2-passive-wave-16ms"), 3000.0, every=0)
    took = time.perf_counter() - start
    stop.set()
    counter.join()
    assert ticks[0] > 20 * took, f"{ticks[0]} times in {took} s"
