"""Figures 8 and 9 of the cooperation paper, run again: where the two copies are, and how far the distance that each peer sees is from
the true one, for three ways to communicate.

    python figure.py [FILE.pdf]

Draws a figure as wide as a page (180 mm), text as text. Needs matplotlib.
"""

import sys

import cohold
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

# Told apart without colours, too (Okabe and Ito).
LINES = {"power": ("#d55e00", "-"), "wave": ("#0072b2", "--"), "passive-wave": ("#009e73", "-.")}


def main(file: str = "figure-8-9.pdf") -> None:
    plt.rcParams |= {"font.size": 8, "pdf.fonttype": 42, "svg.fonttype": "none"}
    figure, (place, apart) = plt.subplots(1, 2, figsize=(180 / 25.4, 70 / 25.4), layout="constrained")
    for comm, (colour, dash) in LINES.items():
        run = cohold.run(cohold.Scene(f"paper-5.2-{comm}-16ms"), seconds=20.0)
        time_s, last = run.columns["time_s"], slice(14_000, 19_000)
        place.plot(time_s[last], 1e3 * run.columns["object_1_m"][last], color=colour, ls=dash, label=comm)
        place.plot(time_s[last], 1e3 * run.columns["object_2_m"][last], color=colour, ls=dash, alpha=0.5)
        for name, alpha in (("true_discrepancy_m", 1.0), ("decoded_discrepancy_2_m", 0.5)):
            # Over a second: what counts is how far apart they stay, not each ripple.
            mean_m = np.convolve(run.columns[name], np.full(1000, 1e-3), mode="same")
            apart.semilogy(time_s[last], 1e3 * mean_m[last], color=colour, ls=dash, alpha=alpha)
        true_mm, decoded_mm = run.merits["true_discrepancy_mm"], run.merits["decoded_discrepancy_mm"]
        print(f"{comm:12} {run.verdict}: true {true_mm:.3f} mm, decoded {decoded_mm:.3f} mm, {run.state_hash}")
    place.set(xlabel="time (s)", ylabel="copies of peer 1 and, lighter, 2 (mm)")
    apart.set(xlabel="time (s)", ylabel="apart; lighter: decoded (mm)")
    figure.legend(loc="outside upper center", ncols=3, frameon=False)
    figure.savefig(file)


if __name__ == "__main__":
    main(*sys.argv[1:2])
