"""Stepping an object that is shared along two and three axes: a force of each user along each of them."""

import copy
import pickle
import re

import cohold
import numpy as np
import pytest

from test_pair import SCENE, nobody

AXES = [2, 3]
SCALARS = ["f32", "f64", "i32f32"]
# Where joints couple the axes, by how many there are.
COUPLED = {2: "plane", 3: "space"}


def shared(scene, axes):
    """The scene with its object shared along so many axes, which nothing couples."""
    return cohold.Scene(scene, {"axis.count": axes, "axis.shared": axes})


def bits(numbers):
    return np.ascontiguousarray(numbers).view(np.uint64)


@pytest.mark.parametrize("axes", AXES)
@pytest.mark.parametrize("scalar", SCALARS)
@pytest.mark.parametrize("alike", [True, False])
def test_each_of_several_axes_that_nothing_couples_is_a_pair_of_one(axes, scalar, alike):
    scene = nobody(cohold.Scene(SCENE))
    forces = np.random.default_rng(axes).normal(0.0, 1.0, (1500, 2, axes))
    if alike:
        forces[:] = forces[:, :, :1]
    rows = cohold.Pair(shared(scene, axes), scalar).steps(forces)
    assert rows.shape == (1500, axes, 12)
    for axis in range(axes):
        alone = cohold.Pair(scene, scalar).steps(forces[:, :, axis])
        assert alone.any(axis=0).all() and np.array_equal(bits(rows[:, axis]), bits(alone)), axis
    assert alike == np.array_equal(rows[:, 0], rows[:, -1])


@pytest.mark.parametrize("axes", AXES)
@pytest.mark.parametrize("scalar", SCALARS)
@pytest.mark.parametrize("name", [SCENE, "coupled"])
def test_forces_along_every_axis_are_those_of_the_scenes_users(axes, scalar, name):
    scene = cohold.Scene(COUPLED[axes]) if name == "coupled" else shared(SCENE, axes)
    # A push along the first axis toward the other peer, and one along the others toward their positive end.
    scene = cohold.Scene(nobody(scene), {"user.1.push_n": 1.5, "user.1.side_push_n": -0.75, "user.2.push_n": 0.5, "user.2.side_push_n": 0.25})
    for user in ("user.1", "user.2"):
        scene[f"{user}.direction_rad"] = scene[f"{user}.elevation_rad"] = 0.0
    run = cohold.run(scene, 1.0, scalar, every=1)
    assert len(run.axes) == axes
    alone = cohold.Scene(nobody(scene), {"user.1.side_push_n": 0.0, "user.2.side_push_n": 0.0})
    pushes = [1.5] + (axes - 1) * [-0.75], [0.5] + (axes - 1) * [-0.25]
    pair, state_hash, rows = cohold.Pair(alone, scalar), None, []
    for _ in range(1000):
        rows.append(pair.step(*pushes))
        state_hash = pair.state_hash() if state_hash is None else pair.state_hash(state_hash)
    assert f"{state_hash:016x}" == run.state_hash
    rows = np.array(rows)
    for axis, columns in enumerate(run.axes):
        for at, column in enumerate(cohold.Pair.COLUMNS):
            assert np.array_equal(rows[:, axis, at], columns[column]), (axis, column)
    assert rows[-1, 1:].any()


def test_what_users_do_in_any_direction_is_theirs_turned_the_opposite_way():
    directions = {"user.1.direction_rad": 0.7, "user.1.elevation_rad": 0.3, "user.2.direction_rad": -1.2, "user.2.elevation_rad": 0.9}
    scene = cohold.Scene(nobody(shared(SCENE, 3)), {"user.1.push_n": 1.0, "user.2.push_n": 2.0, **directions})
    run = cohold.run(scene, 1.0, every=1)
    turned = lambda user: np.array(
        [np.cos(scene[f"{user}.direction_rad"]), np.sin(scene[f"{user}.direction_rad"]), np.tan(scene[f"{user}.elevation_rad"])]
    ) * np.cos(scene[f"{user}.elevation_rad"])
    forces = np.tile(np.stack([turned("user.1"), 2.0 * turned("user.2")]), (1000, 1, 1))
    rows = cohold.Pair(nobody(scene)).steps(forces)
    for axis, columns in enumerate(run.axes):
        for at, column in enumerate(cohold.Pair.COLUMNS):
            assert np.abs(columns[column]).max() > 1e-6
            assert np.allclose(rows[:, axis, at], columns[column], rtol=0, atol=1e-9), (axis, column)


@pytest.mark.parametrize("axes", AXES)
def test_one_tick_and_many_are_the_same_along_every_axis(axes):
    scene = cohold.Scene(COUPLED[axes])
    forces = np.random.default_rng(1).normal(0.0, 0.1, (300, 2, axes))
    one, of_lists, into, many = (cohold.Pair(scene) for _ in range(4))
    stepped = [one.step(*row) for row in forces]
    assert isinstance(stepped[0], tuple) and isinstance(stepped[0][0], tuple)
    listed = [of_lists.step(*map(list, row)) for row in forces]
    out = np.empty((300, axes, 12))
    for row, place in zip(forces, out):
        into.step_into(tuple(row[0]), row[1], place)
    rows = many.steps(forces)
    assert np.array_equal(np.array(stepped), rows) and listed == stepped and np.array_equal(out, rows)
    assert many.ticks == 300 and many.time_s == pytest.approx(0.3) and many.fault is None
    assert one.state_hash() == into.state_hash() == many.state_hash()


def test_memory_order_of_forces_along_several_axes_does_not_matter():
    # More rows than are taken over at a time.
    forces = np.random.default_rng(2).normal(0.0, 1.0, (70_000, 2, 2))
    given = [forces, np.asfortranarray(forces), np.ascontiguousarray(forces.transpose(2, 0, 1)).transpose(1, 2, 0), np.repeat(forces, 2, axis=2)[:, :, ::2]]
    first, *others = [cohold.Pair(shared(SCENE, 2)).steps(each) for each in given]
    assert all(np.array_equal(first, other) for other in others)


def refused(call, says):
    with pytest.raises(ValueError) as error:
        call()
    assert says in str(error.value)


@pytest.mark.parametrize("axes", [1, *AXES])
def test_a_wrong_shape_is_refused_with_the_right_one_and_nothing_moves(axes):
    pair = cohold.Pair(shared(SCENE, axes) if axes > 1 else cohold.Scene(SCENE))
    good, row = (0.0, (12,)) if axes == 1 else ([0.0] * axes, (axes, 12))
    out = np.zeros(row)
    must = "it must be a number" if axes == 1 else f"it must have shape ({axes},), a number for each shared axis"
    wrong = [[0.0] * count for count in (0, 1, 2, 3, 4, 10**6) if count != axes or axes == 1] + ([0.5] if axes > 1 else [])
    for forces in wrong:
        given = "= 0.5" if isinstance(forces, float) else f"of shape ({len(forces)},)"
        refused(lambda: pair.step(forces, good), f"force_1_n {given} is not allowed: {must}")
        refused(lambda: pair.step_into(good, forces, out), f"force_2_n {given} is not allowed: {must}")
    if axes > 1:
        refused(lambda: pair.step(np.zeros(axes + 1), good), f"force_1_n of shape ({axes + 1},) is not allowed: {must}")
    rows = "(ticks, 2), user 1 and user 2" if axes == 1 else f"(ticks, 2, {axes}), user 1 and user 2 along each shared axis"
    shapes = [(), (2,), (3, 3), (0, 3), (3, 2, 4), (4, 3, 2), (3, 2, 2, 1), (3,) + 40 * (1,), (3, 2) if axes > 1 else (3, 2, 1)]
    for shape in shapes:
        refused(lambda: pair.steps(np.zeros(shape)), f"forces_n of shape {shape} is not allowed: it must have shape {rows}")
    for shape in [(), (11,), (12, 2), (1, 12), (2, 13), (4, 12), (24,), 40 * (1,), (12,) if axes > 1 else (2, 12)]:
        refused(lambda: pair.step_into(good, good, np.zeros(shape)), f"out of shape {shape} is not allowed: it must have shape {row}")
    for none in ("ab", None, [None] * axes, ["1"] * axes):
        with pytest.raises(TypeError):
            pair.step(none, good)
    assert pair.ticks == 0


@pytest.mark.parametrize("axes", AXES)
def test_a_force_that_is_none_is_refused_along_every_axis_and_nothing_moves(axes):
    pair = cohold.Pair(shared(SCENE, axes))
    out, good = np.zeros((axes, 12)), [0.0] * axes
    for axis in range(axes):
        for force in (float("nan"), float("inf"), -1000.5):
            wrong = good.copy()
            wrong[axis] = force
            # Behind as many as are taken over at a time.
            many = np.zeros((70_000, 2, axes))
            many[-1, 1, axis] = force
            for step in (lambda: pair.step(wrong, good), lambda: pair.step_into(good, wrong, out), lambda: pair.steps(many)):
                with pytest.raises(ValueError, match="it must be a number from -1000 to 1000 N"):
                    step()
    assert pair.ticks == 0


def test_forces_along_several_axes_that_there_is_no_room_for_are_refused():
    pair = cohold.Pair(shared(SCENE, 3))
    for rows in (20_000_001, 10**9, 2**57):
        forces = np.broadcast_to(np.zeros((2, 3)), (rows, 2, 3))
        refused(lambda: pair.steps(forces), f"forces_n of {rows} rows is not allowed: it must have at most 20000000")
    assert pair.ticks == 0
    assert pair.steps(np.broadcast_to(np.ones((2, 3)), (100, 2, 3))).shape == (100, 3, 12)
    assert pair.steps(np.zeros((0, 2, 3))).shape == (0, 3, 12)


def test_a_pair_along_several_axes_that_stopped_says_so_and_cannot_be_copied():
    scene = cohold.Scene("paper-5.1-power-16ms", {"coordination.stiffness_n_per_m": 50_000})
    pair = cohold.Pair(shared(scene, 2))
    pair.steps(np.ones((5000, 2, 2)))
    peer, fault = pair.fault
    assert peer in (1, 2) and fault
    for copied in (copy.copy, copy.deepcopy, pickle.dumps):
        with pytest.raises(TypeError, match=re.escape("Pair")):
            copied(pair)
