"""Many pairs in one call: each is a pair alone, to the last bit."""

import cohold
import numpy as np
import pytest
from test_pair import nobody

LOSSY = cohold.Scene("any-network", {"network.loss": 0.3})


def alone(scene, seed, scalar="f64"):
    scene = cohold.Scene(scene)
    scene["network.seed"] = seed
    return cohold.Pair(scene, scalar)


@pytest.mark.parametrize(("scalar", "threads"), [("f32", 1), ("f64", 3), ("i32f32", 8)])
def test_each_is_a_pair_alone(scalar, threads):
    seeds, draw = [3, 1, 4, 1, 5], np.random.default_rng(2)
    pairs = cohold.Pairs(LOSSY, 5, scalar, threads)
    pairs.begin(range(5), seeds)
    each = [alone(LOSSY, seed, scalar) for seed in seeds]
    shared = [cohold.Pairs.COLUMNS.index(name) for name in cohold.Pair.COLUMNS]
    for ticks in (1, 20, 7):
        forces = draw.normal(1.0, 1.0, (5, 2))
        seen = pairs.steps(forces, ticks)
        rows = [pair.steps(np.tile(force, (ticks, 1)))[-1] for pair, force in zip(each, forces)]
        assert np.array_equal(seen[:, shared], rows) and np.array_equal(pairs.seen(), seen)
    assert pairs.state_hashes() == [pair.state_hash() for pair in each]
    assert len(pairs) == 5 and pairs.faults == [None] * 5 and pairs.engaged.all() and pairs.engaged.shape == (5, 2)


def test_beginning_anew_is_a_new_pair():
    pairs, forces = cohold.Pairs(LOSSY, 3), np.ones((3, 2))
    pairs.begin([0, 1, 2], [7, 8, 9])
    pairs.steps(forces * [1.0, 0.5], 500)
    pairs.begin(np.array([2, 0]), np.array([8, 9]))
    seen = pairs.steps(forces * [2.0, 0.5], 300)
    shared = [cohold.Pairs.COLUMNS.index(name) for name in cohold.Pair.COLUMNS]
    for at, seed in ((2, 8), (0, 9)):
        assert np.array_equal(seen[at, shared], alone(LOSSY, seed).steps(np.tile([2.0, 0.5], (300, 1)))[-1])
    other = alone(LOSSY, 8)
    other.steps(np.tile([1.0, 0.5], (500, 1)))
    assert np.array_equal(seen[1, shared], other.steps(np.tile([2.0, 0.5], (300, 1)))[-1])


def test_the_motor_presses_back_what_the_hand_pushes():
    """At rest a motor holds its hand: user 1's push of 1 N along x is met by -1 N, user 2's the other way by +1 N."""
    pairs = cohold.Pairs(cohold.Scene("any-network", {"user.1.push_n": 0.0, "user.2.push_n": 0.0}), 2)
    seen = pairs.steps(np.ones((2, 2)), 20_000)
    at = [cohold.Pairs.COLUMNS.index(f"motor_{peer}_n") for peer in (1, 2)]
    assert np.allclose(seen[:, at], [-1.0, 1.0], atol=1e-3)


def test_along_several_axes():
    scene = cohold.Scene("any-network", {"axis.count": 2, "axis.shared": 2})
    forces = np.random.default_rng(3).normal(0.0, 1.0, (4, 2, 2))
    seen = cohold.Pairs(scene, 4, threads=2).steps(forces, 50)
    assert seen.shape == (4, 2, 22)
    shared = [cohold.Pairs.COLUMNS.index(name) for name in cohold.Pair.COLUMNS]
    for row, force in zip(seen, forces):
        assert np.array_equal(row[:, shared], cohold.Pair(scene).steps(np.tile(force, (50, 1, 1)))[-1])


def test_what_stopped_says_so():
    pairs = cohold.Pairs(nobody(cohold.Scene("paper-5.1-power-16ms", {"coordination.stiffness_n_per_m": 50_000})), 2)
    pairs.steps(np.array([[1.0, 1.0], [0.0, 0.0]]), 5000)
    stopped, other = pairs.faults
    assert stopped[0] in (1, 2) and stopped[1] and other is None
    assert not pairs.engaged[0].all() and pairs.engaged[1].all()


def test_what_is_not_allowed_is_refused():
    pairs = cohold.Pairs(LOSSY, 2)
    wrong = [
        (lambda: cohold.Pairs(LOSSY, 0), "count = 0 is not allowed: it must be a whole number from 1 to 100000"),
        (lambda: cohold.Pairs(LOSSY, 2, threads=0), "threads = 0 is not allowed"),
        (lambda: cohold.Pairs(LOSSY, 2, "f16"), 'scalar = "f16" is not allowed'),
        (lambda: pairs.begin([2], [1]), "pair = 2 is not allowed: it must be a whole number from 0 to 1"),
        (lambda: pairs.begin([0], [-1]), "seed = -1 is not allowed"),
        (lambda: pairs.begin([0, 1], [1]), "1 seeds are not allowed: there must be as many as pairs, 2"),
        (lambda: pairs.steps(np.ones((3, 2))), r"forces_n of shape \(3, 2\) is not allowed: it must have shape \(2, 2\)"),
        (lambda: pairs.steps(np.ones((2, 2)), 0), "ticks = 0 is not allowed"),
        (lambda: pairs.steps(np.array([[0.0, 0.0], [np.nan, 0.0]])), "it must be a number from -1000 to 1000 N"),
    ]
    before = pairs.state_hashes()
    for call, says in wrong:
        with pytest.raises(ValueError, match=says):
            call()
    assert pairs.state_hashes() == before
