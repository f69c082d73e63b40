# SPDX-License-Identifier: MIT OR Apache-2.0
"""Spectral radii per second in NumPy on one core: the work of `host-sim stability bench`, for comparison.

Run side by side:  host-sim stability bench ; OPENBLAS_NUM_THREADS=1 python3 tests/oracle/numpy_speed.py [radii]
                   (with --host-sim PATH it runs the bench too and prints the ratio: all its threads against one NumPy)

The work: Figure 4, passive wave, n_t = 3 (26 states that matter), K_T = 12000 i/N for i = 1..N; for each the lifted matrix, its
quotient by the rest modes, the largest |eigenvalue|. Two ways:
* scene by scene, as a NumPy program is written (`model.spectral_radius`): every scene built from its parameters;
* stacked: the tick matrix is affine in K_T for this law, so all matrices of the sweep are two constant ones and a product,
  multiplied and solved as one (N, n, n) array. As fast as NumPy gets, and good for this one key and law only.
Both give the same checksum (the sum of the radii, as the bench prints it for the same N).
"""
import json
import os
import subprocess
import sys
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import numpy as np

from model import FIG4, complete, lifted, spectral_radius

SCENE = {**FIG4, "network.one_way_delay_packets": 3}
KEY = "coordination.stiffness_n_per_m"


def one_by_one(gains):
    """Every scene on its own."""
    return np.array([spectral_radius({**SCENE, KEY: gain}) for gain in gains])


def live(matrix):
    """Indices that are left when zero rows and columns are removed until none is."""
    keep = np.arange(len(matrix))
    while True:
        part = matrix[np.ix_(keep, keep)] != 0
        good = part.any(0) & part.any(1)
        if good.all():
            return keep
        keep = keep[good]


def stacked(gains):
    """The whole sweep as one array; 24 states after the two rest modes."""
    names, exchange, at_0 = lifted({**SCENE, KEY: 0.0})
    slope = lifted({**SCENE, KEY: 1.0})[2] - at_0
    period = at_0 + np.asarray(gains)[:, None, None] * slope
    for _ in range(complete(SCENE)["timing.ticks_per_packet"].bit_length() - 1):  # M = 8: three squarings
        period = period @ period
    period = period @ exchange
    keep = live(period[len(gains) // 2])
    period = period[:, keep[:, None], keep]
    kept = [names[k] for k in keep]
    rest = np.array([[name.startswith("x_") and peer == i for peer, name in kept] for i in (0, 1)], float).T
    basis = np.linalg.qr(rest, mode="complete")[0][:, 2:]
    return np.abs(np.linalg.eigvals(basis.T @ period @ basis)).max(1), len(keep)


def main():
    arguments = sys.argv[1:]
    program = arguments.pop(arguments.index("--host-sim") + 1) if "--host-sim" in arguments else None
    numbers = [int(a) for a in arguments if a.isdigit()]
    count = numbers[0] if numbers else 2000
    gains = 12000.0 * (np.arange(count) + 1) / count
    one_by_one(gains[:20]), stacked(gains[:20])
    rates = []
    start = time.perf_counter()
    radii = one_by_one(gains)
    rates.append(("scene by scene", count / (time.perf_counter() - start), radii.sum()))
    start = time.perf_counter()
    radii, states = stacked(gains)
    rates.append((f"stacked ({states} states)", count / (time.perf_counter() - start), radii.sum()))
    for name, rate, checksum in rates:
        print(f"NumPy {np.__version__}, one core, {name:<22} {rate:8.0f} radii/s   checksum {checksum:.9f}")
    if program:
        bench = json.loads(subprocess.run([program, "stability", "bench", "--radii", str(count), "--json"],
                                          check=True, capture_output=True, text=True).stdout)
        for speed in bench:
            ratios = ", ".join(f"{speed['radii_per_s'] / rate:.1f} x {name}" for name, rate, _ in rates)
            print(f"host-sim, {speed['threads']} thread(s), {speed['states']} states: {speed['radii_per_s']:.0f} radii/s "
                  f"= {ratios}   checksum {speed['checksum']:.9f}")


if __name__ == "__main__":
    main()
