"""A closed loop with a user model of one's own: user 1 carries the object to a target that user 2 does not know of.

    python own_user.py

User 1 sees the object 150 ms late, as eyes do, and pulls it by a spring and a damper of the arm, with no more than 4 N; user 2 holds on,
held back by nothing but a soft arm. The forces are computed here, tick by tick; peers, devices and network are the simulator's.
"""

from collections import deque

import cohold

TARGET_M = 0.03
SEES_LATE_TICKS = 150


class Reaching:
    """A person who steers by what was seen a while ago."""

    def __init__(self, target_m: float):
        self.target_m = target_m
        self.seen = deque([0.0] * SEES_LATE_TICKS, maxlen=SEES_LATE_TICKS)

    def force_n(self, object_m: float, device_m: float, before_m: float) -> float:
        late_m = self.seen[0]
        self.seen.append(object_m)
        velocity = (device_m - before_m) / 0.001
        # The arm is felt at once, the object is seen late.
        return max(-4.0, min(4.0, 40.0 * (self.target_m - late_m) - 12.0 * velocity))


def main() -> None:
    scene = cohold.Scene("any-network", {"network.loss": 0.1})
    for user in (1, 2):
        scene[f"user.{user}.push_n"] = 0.0
    pair = cohold.Pair(scene)
    at = {name: place for place, name in enumerate(cohold.Pair.COLUMNS)}
    person = Reaching(TARGET_M)
    row, before_m = pair.step(0.0, 0.0), 0.0
    while pair.time_s < 6.0:
        device_m, object_m = row[at["device_1_m"]], row[at["object_1_m"]]
        pull = person.force_n(object_m, device_m, before_m)
        before_m = device_m
        # Forces are toward the other peer: user 2 pushes against what comes, gently.
        row = pair.step(pull, 2.0 * row[at["device_2_m"]])
        if pair.fault:
            raise SystemExit(f"peer {pair.fault[0]} stopped: {pair.fault[1]}")
    for peer in (1, 2):
        print(f"copy {peer} is at {1e3 * row[at[f'object_{peer}_m']]:.1f} mm after {pair.time_s:.1f} s; the target is {1e3 * TARGET_M:.0f} mm")


if __name__ == "__main__":
    main()
