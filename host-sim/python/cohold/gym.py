"""An environment for Gymnasium: one user's hand carries an object to a place, together with a partner, over a network that loses packets.

    import gymnasium, cohold.gym
    env = gymnasium.make("haptic/Carry-v0")
    envs = gymnasium.make_vec("haptic/Carry-v0", num_envs=256)        # one native call a step for all

The agent is the hand of user 1: what it does is the force that it pushes with, held for `step_s`. User 2 pushes against it with a steady force
that is drawn anew at each reset, as the place and the losses are; what else the scene's users do, they do as well.

    action        force toward the other peer, N, from -most_n to most_n; what is beyond is what the hand can do
    observation   OBSERVED, saturated at its bounds, of the agent's own side alone
    reward        - the mean distance of both copies of the object from the place, m, at the end of the step, each at most FAR
    terminated    a peer stopped, or a hand or a copy is farther than reach_m from where it began: then the reward is - FAR for this step and
                  each that is left, so that no run ends early for profit
    truncated     after `seconds`

FAR is reach_m + target_m, the farthest that a copy within reach is from the place. Nothing else is rewarded. `info` has the partner's force
(`partner_n`) at each reset, and why a run was terminated (`failed`).
"""

from collections.abc import Sequence
from typing import Any, Literal

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from ._native import Pairs, Scene

__all__ = ["OBSERVED", "CarryEnv", "CarryVectorEnv"]

_Floats = NDArray[np.float32]
_Value = bool | int | float | str

# What the agent observes: the name, which column of `Pairs` it is, and its bound in the unit at the end of the name; None is the reach.
_SEEN: list[tuple[str, str, float | None]] = [
    ("hand_m", "device_1_m", None),
    ("hand_m_per_s", "device_1_m_per_s", 2.0),
    ("felt_n", "motor_1_n", 20.0),
    ("object_m", "object_1_m", None),
    ("object_m_per_s", "object_1_m_per_s", 2.0),
    ("partner_object_m", "decoded_1_m", None),
]
OBSERVED = [name for name, _, _ in _SEEN] + ["target_m", "coupled"]
_AT = {name: at for at, name in enumerate(Pairs.COLUMNS)}
_COLUMNS = [_AT[column] for _, column, _ in _SEEN]
_COPIES = [_AT["object_1_m"], _AT["object_2_m"]]
_PLACES = [*_COPIES, _AT["device_1_m"], _AT["device_2_m"]]


def _lossy() -> Scene:
    return Scene("any-network", {"network.loss": 0.2})


class _Hands:
    """So many runs, each with a generator of its own."""

    def __init__(
        self,
        count: int,
        scene: Scene | str | None = None,
        partner_n: tuple[float, float] = (0.5, 1.5),
        most_n: float = 3.0,
        target_m: float = 0.05,
        reach_m: float = 0.2,
        step_s: float = 0.02,
        seconds: float = 5.0,
        scalar: Literal["f32", "f64", "i32f32"] = "f64",
        threads: int = 1,
    ):
        self.scene = _lossy() if scene is None else Scene(scene)
        if self.scene["axis.shared"] != 1:
            raise ValueError(f"axis.shared = {self.scene['axis.shared']:g} is not allowed: the hand pushes along one axis")
        period_s = float(self.scene["timing.control_period_s"])
        limits = {"most_n": (most_n, 0.0, 1000.0, "N"), "target_m": (target_m, 0.0, reach_m, "m"), "reach_m": (reach_m, 0.0, 10.0, "m")}
        limits |= {"step_s": (step_s, period_s, seconds, "s"), "seconds": (seconds, step_s, 1e6, "s")}
        limits |= {f"partner_n[{at}]": (force, -1000.0, 1000.0, "N") for at, force in enumerate(partner_n)}
        for name, (value, least, most, unit) in limits.items():
            if not least <= value <= most:
                raise ValueError(f"{name} = {value} is not allowed: it must be a number from {least:g} to {most:g} {unit}")
        if len(partner_n) != 2 or partner_n[0] > partner_n[1]:
            raise ValueError(f"partner_n = {partner_n} is not allowed: it must be two forces, the least and the largest")
        self.count, self.partner_range_n, self.most_n = count, partner_n, most_n
        self.place_range_m, self.reach_m, self.far_m = target_m, reach_m, reach_m + target_m
        self.ticks, self.steps = round(step_s / period_s), round(seconds / step_s)
        self.pairs = Pairs(self.scene, count, scalar, threads)
        self.target_m, self.partner_n, self.done = np.zeros(count), np.zeros(count), np.zeros(count, int)
        bounds = [reach_m if bound is None else bound for _, _, bound in _SEEN] + [reach_m, 1.0]
        self.high = np.array(bounds, np.float32)
        self.low = np.where(np.arange(len(bounds)) == len(bounds) - 1, np.float32(0.0), -self.high)
        self.observation_space = Box(self.low, self.high, dtype=np.float32)
        self.action_space = Box(-most_n, most_n, (1,), np.float32)

    def begin(self, these: Sequence[int] | NDArray[Any], generators: Sequence[np.random.Generator]) -> None:
        """Draws network, place and partner of these runs anew, each from its own generator."""
        seeds = []
        for at, draw in zip(these, generators, strict=True):
            seeds.append(int(draw.integers(2**32)))
            self.target_m[at] = draw.uniform(-self.place_range_m, self.place_range_m)
            self.partner_n[at] = draw.uniform(*self.partner_range_n)
            self.done[at] = 0
        self.pairs.begin(these, seeds)

    def observed(self, seen: NDArray[np.float64]) -> _Floats:
        coupled = self.pairs.engaged[:, 0]
        observed = np.column_stack([seen[:, _COLUMNS], self.target_m, coupled]).astype(np.float32)
        return np.clip(observed, self.low, self.high)

    def step(self, actions: NDArray[Any]) -> tuple[_Floats, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_]]:
        pushes = np.clip(np.asarray(actions, np.float64).reshape(self.count), -self.most_n, self.most_n)
        seen = self.pairs.steps(np.column_stack([pushes, self.partner_n]), self.ticks)
        self.done += 1
        stopped = np.array([fault is not None for fault in self.pairs.faults])
        lost = stopped | (np.abs(seen[:, _PLACES]) > self.reach_m).any(1)
        off_m = np.minimum(np.abs(seen[:, _COPIES] - self.target_m[:, None]), self.far_m).mean(1)
        left = np.maximum(self.steps - self.done + 1, 1)
        reward = -np.where(lost, self.far_m * left, off_m)
        return self.observed(seen), reward, lost, ~lost & (self.done >= self.steps)

    def why(self, at: int) -> str:
        fault = self.pairs.faults[at]
        return f"peer {fault[0]} stopped: {fault[1]}" if fault else f"beyond {self.reach_m:g} m"


class CarryEnv(gymnasium.Env[_Floats, _Floats]):
    """`haptic/Carry-v0`: the module says what it is. `scene` is a Scene or the name of one, along one axis."""

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(self, render_mode: None = None, **settings: Any):
        self.render_mode = render_mode
        self._hands = _Hands(1, **settings)
        self.observation_space, self.action_space = self._hands.observation_space, self._hands.action_space

    @property
    def scene(self) -> Scene:
        """What is run, for `stability` to judge."""
        return self._hands.scene

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[_Floats, dict[str, Any]]:
        super().reset(seed=seed)
        hands = self._hands
        hands.begin([0], [self.np_random])
        return hands.observed(hands.pairs.seen())[0], {"partner_n": float(hands.partner_n[0])}

    def step(self, action: _Floats) -> tuple[_Floats, float, bool, bool, dict[str, Any]]:
        observed, reward, lost, over = self._hands.step(action)
        info = {"failed": self._hands.why(0)} if lost[0] else {}
        return observed[0], float(reward[0]), bool(lost[0]), bool(over[0]), info


class CarryVectorEnv(VectorEnv[_Floats, _Floats, NDArray[Any]]):
    """So many of `haptic/Carry-v0`, stepped natively in one call on `threads`; a run that is over begins anew in the next step, as Gymnasium's
    own vectors do by default. Each gives what `CarryEnv` does with its seed: `reset(seed=n)` gives run i the seed n + i.
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(self, num_envs: int = 1, render_mode: None = None, **settings: Any):
        self.num_envs, self.render_mode = num_envs, render_mode
        self._hands = hands = _Hands(num_envs, **settings)
        self.single_observation_space, self.single_action_space = hands.observation_space, hands.action_space
        self.observation_space = batch_space(hands.observation_space, num_envs)
        self.action_space = batch_space(hands.action_space, num_envs)
        self._draw = [seeding.np_random()[0] for _ in range(num_envs)]
        self._over = np.zeros(num_envs, bool)

    @property
    def scene(self) -> Scene:
        """What is run, for `stability` to judge."""
        return self._hands.scene

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[_Floats, dict[str, Any]]:
        seeds = [seed + at for at in range(self.num_envs)] if isinstance(seed, int) else seed
        if seeds is not None:
            if len(seeds) != self.num_envs:
                raise ValueError(f"{len(seeds)} seeds are not allowed: there must be as many as environments, {self.num_envs}")
            for at, own in enumerate(seeds):
                if own is not None:
                    self._draw[at] = seeding.np_random(own)[0]
        self._over[:] = False
        everyone = np.arange(self.num_envs)
        self._hands.begin(everyone, self._draw)
        return self._hands.observed(self._hands.pairs.seen()), self._told(everyone)

    def step(
        self, actions: _Floats
    ) -> tuple[_Floats, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        hands, (anew,) = self._hands, np.nonzero(self._over)
        observed, reward, lost, over = hands.step(actions)
        info: dict[str, Any] = {}
        if len(anew):
            hands.begin(anew, [self._draw[at] for at in anew])
            observed[anew] = hands.observed(hands.pairs.seen())[anew]
            reward[anew], lost[anew], over[anew] = 0.0, False, False
            info = self._told(anew)
        if lost.any():
            info |= {"failed": np.array([hands.why(at) if is_lost else None for at, is_lost in enumerate(lost)]), "_failed": lost.copy()}
        self._over = lost | over
        return observed, reward, lost, over, info

    def _told(self, these: NDArray[Any]) -> dict[str, Any]:
        began = np.isin(np.arange(self.num_envs), these)
        return {"partner_n": np.where(began, self._hands.partner_n, 0.0), "_partner_n": began}


gymnasium.register("haptic/Carry-v0", entry_point=CarryEnv, vector_entry_point=CarryVectorEnv)
