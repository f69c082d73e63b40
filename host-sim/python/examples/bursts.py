"""Which law bears bursts of loss? A law of one's own beside built-in ones, with the same seeds: paired differences with 95 % intervals.

    python bursts.py [SEEDS]

The own law is the paper's power-domain law whose remote copy comes to rest while nothing comes. It is written in Python for trying it
out: a run takes some ten times as long as with a law in Rust.
"""

import math
import sys

import cohold
import numpy as np

# The values of the settings that a law reads; of a copy: position and velocity.
Floats = tuple[float, ...]


class Rest:
    """A spring to the last known place of the remote copy, whose velocity is forgotten with every tick of silence."""

    name = "rest"
    sends = "motion"
    keys = {"rest.forget": (0.98, 0.0, 1.0, "", "What is left of the remote velocity after a tick without a packet.")}
    reads = ("coordination.stiffness_n_per_m", "coordination.damping_n_s_per_m", "rest.forget")
    gains = ("coordination.stiffness_n_per_m=310",)

    def start(self, values: Floats, local: Floats) -> Floats:
        return local

    def receive(self, values: Floats, state: Floats, packet: Floats) -> Floats:
        return packet

    def couple(
        self, values: Floats, state: Floats, local: Floats, contact_force_n: float, age_ticks: int
    ) -> tuple[Floats, float, Floats]:
        stiffness, damping, forget = values
        velocity = forget * state[1]
        force = stiffness * (state[0] - local[0]) + damping * (velocity - local[1])
        return (state[0], velocity), force, (state[0], velocity)

    def send(self, values: Floats, state: Floats, local: Floats) -> Floats:
        return local


# A gain at which each is stable without loss.
GAINS = {"power": 200.0, "wave": 1500.0, "passive-wave": 4000.0, "rest": 200.0}
# Student's t at 97.5 % for 4, 9, 19 degrees of freedom.
STUDENT = {5: 2.776, 10: 2.262, 20: 2.093}


def main(seeds: int = 10) -> None:
    cohold.add_law(Rest())
    lengths = [1, 5, 20]
    bursts: dict[str, list[float]] = {"network.loss": [0.1], "network.loss_burst_packets": [*lengths]}
    tables = {}
    for law, stiffness in GAINS.items():
        settings: dict[str, float | str] = {"coordination.comm": law, "coordination.stiffness_n_per_m": stiffness}
        scene = cohold.Scene("paper-5.2-power-16ms", settings)
        tables[law] = cohold.Sweep(scene, bursts, seeds=seeds, seconds=4.0).run()
    print("true discrepancy, mm: mean, and difference from `power` over the same seeds with half of its 95 % interval\n")
    for burst in lengths:
        first = None
        for law, table in tables.items():
            here = table["network.loss_burst_packets"] == burst
            apart_mm = table["true_discrepancy_mm"][here]
            if first is None:
                first = apart_mm
                print(f"bursts of {burst:2}  {law:13} {apart_mm.mean():8.3f}")
                continue
            difference = apart_mm - first
            half = STUDENT.get(seeds, 1.96) * difference.std(ddof=1) / math.sqrt(seeds)
            # A run that failed has no figure: its point has no mean, and says why.
            reasons = {reason for reason in table["reason"][here] if reason}
            told = f"{difference.mean():+8.3f} ± {half:.3f}" if not np.isnan(difference).any() else min(reasons, default="no pair")
            came_apart = int((table["verdict"][here] == "apart").sum())
            told += f"  ({came_apart} of {seeds} runs came apart)" if came_apart else ""
            print(f"bursts of {burst:2}  {law:13} {apart_mm.mean():8.3f}  {told}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))
