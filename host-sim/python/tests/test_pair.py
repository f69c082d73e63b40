"""Stepping: forces from Python are what the scene's own users would be."""

import cohold
import numpy as np
import pytest

SCENE = "paper-5.2-passive-wave-16ms"


def nobody(scene):
    """The scene without its users, and what they do in N, tick by tick, toward the other peer."""
    scene = cohold.Scene(scene)
    for key in ("user.1.push_n", "user.2.push_n", "user.1.pulse_n", "user.2.pulse_n", "user.1.sine_n", "user.2.sine_n"):
        scene[key] = 0
    return scene


@pytest.mark.parametrize("scalar", ["f32", "f64", "i32f32"])
def test_forces_from_python_are_those_of_the_scenes_users(scalar):
    users = cohold.Scene(SCENE, {"user.1.push_n": 1.5, "user.2.push_n": 0.0, "user.2.sine_n": 2.0, "user.2.sine_rad_per_s": 3.0})
    run = cohold.run(users, 2.0, scalar)
    time_s = run.columns["time_s"]
    forces = np.stack([np.full(2000, 1.5), [2.0 * np.sin(3.0 * t) for t in time_s]], 1)
    pair, state_hash = cohold.Pair(nobody(users), scalar), None
    rows = []
    for first, second in forces:
        rows.append(pair.step(first, second))
        state_hash = pair.state_hash() if state_hash is None else pair.state_hash(state_hash)
    rows = np.array(rows)
    for at, name in enumerate(cohold.Pair.COLUMNS):
        assert np.allclose(rows[:, at], run.columns[name], rtol=0, atol=1e-9), name
    # The constant push to the last bit; the sine of another mathematics library may differ in its own last one.
    push = cohold.Scene(users, {"user.2.sine_n": 0.0})
    run, pair = cohold.run(push, 1.0, scalar), cohold.Pair(nobody(push), scalar)
    state_hash = None
    for _ in range(1000):
        pair.step(1.5, 0.0)
        state_hash = pair.state_hash() if state_hash is None else pair.state_hash(state_hash)
    assert f"{state_hash:016x}" == run.state_hash


def test_one_tick_and_many_are_the_same():
    forces = np.random.default_rng(1).normal(0.0, 1.0, (500, 2))
    one, into, many = (cohold.Pair(cohold.Scene(SCENE)) for _ in range(3))
    stepped = np.array([one.step(*row) for row in forces])
    out = np.empty((500, 12))
    for row, place in zip(forces, out):
        into.step_into(*row, place)
    rows = many.steps(forces)
    assert np.array_equal(stepped, rows) and np.array_equal(out, rows)
    assert many.ticks == 500 and many.time_s == pytest.approx(0.5) and many.fault is None
    assert one.state_hash() == into.state_hash() == many.state_hash()


def test_forces_may_be_any_numbers_and_what_is_stepped_says_so():
    rows = [[1.0, -0.5]] * 100
    pairs = [cohold.Pair(SCENE) for _ in range(3)]
    given = [np.array(rows), np.array(rows, np.float32), rows]
    first, *others = [pair.steps(each) for pair, each in zip(pairs, given)]
    assert all(np.array_equal(first, other) for other in others)
    assert repr(pairs[0]) == "<Pair after 100 ticks>"
    pairs = cohold.Pairs(SCENE, 2)
    assert np.array_equal(pairs.steps([[1, 0], [0, 1]]), cohold.Pairs(SCENE, 2).steps(np.eye(2)))
    assert repr(pairs) == "<2 Pairs, f64>" and repr(cohold.Peer(SCENE, 1)) == "<Peer after 0 ticks>"


def test_memory_order_of_forces_does_not_matter():
    forces = np.stack([np.ones(500), np.linspace(0.0, -2.0, 500)], 1)
    pairs = [cohold.Pair(cohold.Scene(SCENE)) for _ in range(3)]
    given = [forces, np.asfortranarray(forces), np.repeat(forces, 2, axis=1)[:, ::2]]
    first, *others = [pair.steps(each) for pair, each in zip(pairs, given)]
    assert all(np.array_equal(first, other) for other in others)


def test_numbers_that_lie_askew_in_memory_are_refused():
    askew = np.frombuffer(bytearray(8 * 24 + 1), dtype=np.uint8)[1:].view(np.float64)
    pair = cohold.Pair(cohold.Scene(SCENE))
    with pytest.raises(ValueError, match="forces_n is not aligned in memory"):
        pair.steps(askew[:20].reshape(10, 2))
    with pytest.raises(ValueError, match="out is not aligned in memory"):
        pair.step_into(0.0, 0.0, askew[:12])
    assert pair.ticks == 0
    pair.steps(np.require(askew[:20].reshape(10, 2), requirements="A"))


def test_a_force_that_is_none_is_refused_and_nothing_moves():
    pair = cohold.Pair(cohold.Scene(SCENE))
    out = np.zeros(12)
    for force in (float("nan"), float("inf"), 1000.5):
        for step in (lambda: pair.step(force, 0.0), lambda: pair.step_into(0.0, force, out), lambda: pair.steps(np.array([[0.0, force]]))):
            with pytest.raises(ValueError, match="it must be a number from -1000 to 1000 N"):
                step()
    assert pair.ticks == 0


def test_a_pair_that_stopped_says_so():
    pair = cohold.Pair(cohold.Scene("paper-5.1-power-16ms", {"coordination.stiffness_n_per_m": 50_000}))
    pair.steps(np.ones((5000, 2)))
    peer, fault = pair.fault
    assert peer in (1, 2) and fault


def test_forces_that_there_is_no_room_for_are_refused():
    """Why: a view of two numbers with a thousand million rows ended the interpreter for want of memory."""
    pair = cohold.Pair(cohold.Scene())
    for rows in (20_000_001, 10**9, 2**58):
        forces = np.broadcast_to(np.zeros(2), (rows, 2))
        with pytest.raises(ValueError, match=f"forces_n of {rows} rows is not allowed: it must have at most 20000000"):
            pair.steps(forces)
    assert pair.ticks == 0
    assert pair.steps(np.broadcast_to(np.ones(2), (100, 2))).shape == (100, 12)
