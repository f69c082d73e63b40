"""The environment: Gymnasium's own check, a vector that is its singles, and rewards that a pair alone confirms."""

import warnings

import gymnasium
import cohold
import cohold.gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.utils.seeding import np_random

CARRY = "haptic/Carry-v0"


def steer(observed):
    """A hand that goes to the place by a spring and a damper."""
    at = {name: place for place, name in enumerate(cohold.gym.OBSERVED)}
    pull = 1.0 + 20.0 * (observed[..., at["target_m"]] - observed[..., at["object_m"]]) - 6.0 * observed[..., at["hand_m_per_s"]]
    return pull[..., None].astype(np.float32)


def test_gymnasium_finds_nothing_to_say():
    """But that it would have forces from -1 to 1: they are newtons, and `RescaleAction` is for who wants them so."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", ".*recommend using a symmetric and normalized space")
        check_env(cohold.gym.CarryEnv(), skip_render_check=True)


def test_a_vector_is_its_singles():
    """Beside Gymnasium's own vector of singles: ends of both kinds, and what begins anew after them."""
    settings = {"seconds": 0.5, "reach_m": 0.06, "partner_n": (0.0, 3.0)}
    own = gymnasium.make_vec(CARRY, num_envs=6, threads=2, **settings)
    singles = gymnasium.make_vec(CARRY, num_envs=6, vectorization_mode="sync", **settings)
    assert isinstance(own.unwrapped, cohold.gym.CarryVectorEnv)
    assert own.observation_space == singles.observation_space and own.action_space == singles.action_space
    draw, ends = np.random.default_rng(1), np.zeros(2)
    for given, other in [(own.reset(seed=5), singles.reset(seed=5))]:
        assert np.array_equal(given[0], other[0]) and np.array_equal(given[1]["partner_n"], other[1]["partner_n"])
    for _ in range(120):
        actions = draw.uniform(-3.0, 3.0, (6, 1)).astype(np.float32)
        given, other = own.step(actions), singles.step(actions)
        for one, same in zip(given[:4], other[:4]):
            assert one.dtype == same.dtype and np.array_equal(one, same)
        assert set(given[4]) == set(other[4])
        for name in given[4]:
            assert np.array_equal(given[4][name], other[4][name]), name
        ends += [given[2].sum(), given[3].sum()]
    assert (ends > 5).all(), ends


def test_a_seed_says_everything():
    def run(seed):
        env = gymnasium.make(CARRY)
        rows = [env.reset(seed=seed)[0]]
        rows += [env.step(steer(rows[-1]))[0] for _ in range(50)]
        return np.array(rows)

    assert np.array_equal(run(1), run(1)) and not np.array_equal(run(1), run(2))


def test_observations_and_rewards_are_those_of_a_pair_alone():
    env, draw = gymnasium.make(CARRY, target_m=0.04, step_s=0.03), np_random(9)[0]
    observed, info = env.reset(seed=9)
    seed, target_m, partner_n = int(draw.integers(2**32)), draw.uniform(-0.04, 0.04), draw.uniform(0.5, 1.5)
    assert info["partner_n"] == partner_n
    pair = cohold.Pair(cohold.Scene("any-network", {"network.loss": 0.2, "network.seed": seed}))
    column = cohold.Pair.COLUMNS.index
    for push in (1.0, 1.4, 0.2, 1.5, 9.0, -9.0):
        observed, reward, lost, over, _ = env.step(np.array([push], np.float32))
        row = pair.steps(np.tile([np.clip(np.float32(push), -3, 3), partner_n], (30, 1)))[-1]
        copies = row[[column("object_1_m"), column("object_2_m")]]
        assert reward == -np.mean(np.minimum(np.abs(copies - target_m), 0.24)) and not (lost or over)
        told = dict(zip(cohold.gym.OBSERVED, observed))
        assert told["object_m"] == np.float32(row[column("object_1_m")]) and told["target_m"] == np.float32(target_m)
        assert told["hand_m"] == np.float32(row[column("device_1_m")]) and told["coupled"] == 1.0


def test_no_run_ends_early_for_profit():
    """Who pulls away loses as much as one who is as far off as can be until the end."""
    env = gymnasium.make(CARRY, seconds=4.0)
    env.reset(seed=3)
    total, steps, lost = 0.0, 0, False
    while not lost:
        _, reward, lost, over, info = env.step(np.array([-3.0], np.float32))
        total, steps = total + reward, steps + 1
        assert not over
    assert info["failed"] == "beyond 0.2 m" and steps < 200
    assert reward == pytest.approx(-0.25 * (200 - steps + 1)) and total < -0.25 * (200 - steps + 1)


def test_a_hand_that_steers_gets_there():
    """Nearer, over sixteen places and partners, than one that pushes with the partner's mean."""
    envs = gymnasium.make_vec(CARRY, num_envs=16)

    def total(act):
        observed, _ = envs.reset(seed=100)
        gained, goes_on = np.zeros(16), np.ones(16, bool)
        while goes_on.any():
            observed, reward, lost, over, _ = envs.step(act(observed))
            gained += goes_on * reward
            goes_on &= ~(lost | over)
        return gained.mean()

    steered, steady = total(steer), total(lambda observed: np.ones((16, 1), np.float32))
    assert steered > 0.5 * steady, (steered, steady)


def test_a_fault_ends_a_run():
    scene = cohold.Scene("paper-5.1-power-16ms", {"coordination.stiffness_n_per_m": 50_000})
    env = gymnasium.make(CARRY, scene=scene, reach_m=10.0)
    env.reset(seed=1)
    for _ in range(250):
        _, _, lost, _, info = env.step(np.ones(1, np.float32))
        if lost:
            break
    assert lost and "stopped" in info["failed"]


def test_what_is_not_allowed_is_refused():
    wrong = [
        ({"scene": "no-such-scene"}, "no-such-scene"),
        ({"scene": cohold.Scene("any-network", {"axis.count": 2, "axis.shared": 2})}, "axis.shared = 2 is not allowed"),
        ({"step_s": 0.0}, "step_s = 0.0 is not allowed: it must be a number from 0.001 to 5 s"),
        ({"partner_n": (2.0, 1.0)}, "partner_n"),
        ({"target_m": 0.3}, "target_m = 0.3 is not allowed: it must be a number from 0 to 0.2 m"),
        ({"most_n": float("nan")}, "most_n = nan is not allowed"),
    ]
    for settings, says in wrong:
        with pytest.raises((ValueError, OSError), match=says):
            cohold.gym.CarryEnv(**settings)
    env = cohold.gym.CarryEnv()
    env.reset(seed=1)
    with pytest.raises(ValueError, match="must be a number from -1000 to 1000 N"):
        env.step(np.array([np.nan], np.float32))
    with pytest.raises(ValueError, match="2 seeds are not allowed"):
        cohold.gym.CarryVectorEnv(3).reset(seed=[1, 2])
