"""The environment `haptic/Carry-v0`: a hand that steers beside one that only pushes, and how fast it steps.

    python carry.py [SECONDS-A-MEASUREMENT]

Both hands have the same sixteen places, partners and losses. Then steps a second of processor time: of vectors of 1, 16 and 256, and of as many
single environments that Python steps one after the other. Needs gymnasium.
"""

import sys
import time
from collections.abc import Callable
from typing import Any

import gymnasium
import cohold.gym
import numpy as np
from numpy.typing import NDArray

CARRY = "haptic/Carry-v0"
AT = {name: at for at, name in enumerate(cohold.gym.OBSERVED)}


Floats = NDArray[np.float32]


def steering(observed: Floats) -> Floats:
    """A spring to the place and a damper, over the partner's usual push."""
    off_m = observed[:, AT["target_m"]] - observed[:, AT["object_m"]]
    pushes: Floats = 1.0 + 20.0 * off_m - 6.0 * observed[:, AT["hand_m_per_s"]]
    return pushes[:, None].astype(np.float32)


def steady(observed: Floats) -> Floats:
    return np.ones((len(observed), 1), np.float32)


def reward(hand: Callable[[Floats], Floats]) -> float:
    envs = gymnasium.make_vec(CARRY, num_envs=16)
    observed, _ = envs.reset(seed=1)
    gained, goes_on = np.zeros(16), np.ones(16, bool)
    while goes_on.any():
        observed, more, lost, over, _ = envs.step(hand(observed))
        gained += goes_on * more
        goes_on &= ~(lost | over)
    return float(gained.mean())


def steps_a_second(envs: Any, seconds: float) -> float:
    envs.reset(seed=1)
    actions, steps, started = np.ones((envs.num_envs, 1), np.float32), 0, time.process_time()
    while time.process_time() - started < seconds:
        envs.step(actions)
        steps += envs.num_envs
    return steps / (time.process_time() - started)


def main() -> None:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 2.0
    for hand in (steady, steering):
        print(f"{hand.__name__:9} {reward(hand):7.2f} m, summed over a run")
    print("environments  one call  singles in Python   (steps of 20 ms in a second of processor time)")
    for count in (1, 16, 256):
        vector = steps_a_second(gymnasium.make_vec(CARRY, num_envs=count), seconds)
        singles = steps_a_second(gymnasium.make_vec(CARRY, num_envs=count, vectorization_mode="sync"), seconds)
        print(f"{count:12} {vector:9.0f} {singles:18.0f}")


if __name__ == "__main__":
    main()
