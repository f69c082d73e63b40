# SPDX-License-Identifier: MIT OR Apache-2.0
"""Writes simulations.csv and spectral.csv beside this file: seeded random scenes and what the oracle says of them.

Run: OPENBLAS_NUM_THREADS=1 python3 tests/oracle/generate.py   (same seeds, same scenes; under a minute on one core)

simulations.csv: stable scenes (spectral radius of 8 ms < 0.999), 20 s from rest, mean and sd over the last 10 s at peer 2 (`simulate`).
spectral.csv: stable and unstable scenes. A radius is kept only where two ways of rounding agree to 1e-11 (relative), and where it
is 1e-6 or more away from 1. Scene values are rounded first, so the text is exactly what was computed.
"""
import csv
from pathlib import Path

import numpy as np

from model import DEFAULTS, simulate, spectral_radius

HERE = Path(__file__).parent
COMMAND = "# made by: OPENBLAS_NUM_THREADS=1 python3 tests/oracle/generate.py"
SIMULATIONS, SPECTRA, DURATION_S = 84, 378, 20.0
COMMS = ("power", "wave", "passive-wave")
DECODES = ("delayed", "implicit")
INTEGRATORS = ("forward-euler", "semi-implicit", "exact")
LAWS = [(comm, decode, how) for decode in DECODES for how in INTEGRATORS for comm in COMMS]
LAWS += [(comm, "implicit", "midpoint") for comm in ("power", "wave", "passive-mean", "self-timed")]
LAWS += [("passive-mean", "delayed", "forward-euler"), ("passive-mean", "implicit", "semi-implicit")]


def short(value):
    """Four significant digits: what the file will say."""
    return float(f"{value:.4g}")


def spread(rng, low, high):
    """Log-uniform in [low, high]."""
    return short(np.exp(rng.uniform(np.log(low), np.log(high))))


def force_delay(rng):
    """In ticks: 0, 1 and anything between, a third each."""
    return [0.0, 1.0, short(rng.random())][rng.integers(3)]


def random_scene(rng, law, packets):
    """A scene of the given law (comm, decode, integrator) with a one-way delay of 0 .. packets - 1."""
    comm, decode, integrator = law
    scene = {
        "timing.control_period_s": [0.001, 0.001, 0.001, 0.002][rng.integers(4)],
        "timing.ticks_per_packet": [8, 8, 8, 1, 5, 12][rng.integers(6)],
        "device.mass_kg": spread(rng, 0.05, 1.0),
        "device.damping_n_s_per_m": spread(rng, 0.5, 5.0),
        "device.force_delay_ticks": force_delay(rng),
        "contact.stiffness_n_per_m": spread(rng, 200.0, 2000.0),
        "contact.damping_n_s_per_m": spread(rng, 0.5, 10.0),
        "object.mass_kg": spread(rng, 0.05, 1.0),
        "object.damping_n_s_per_m": [0.0, spread(rng, 0.1, 2.0)][rng.integers(2)],
        "object.force_delay_ticks": force_delay(rng),
        "object.integrator": integrator,
        "coordination.comm": comm,
        "coordination.decode": decode,
        "coordination.stiffness_n_per_m": spread(rng, 50.0, 1500.0 if comm == "power" else 15000.0),
        "coordination.damping_n_s_per_m": spread(rng, 0.5, 10.0),
        "coordination.wave_impedance_n_s_per_m": spread(rng, 5.0, 50.0),
        "coordination.cutoff_hz": [60.0, spread(rng, 20.0, 120.0)][rng.integers(2)],
        "network.one_way_delay_packets": int(rng.integers(packets)),
    }
    if integrator == "midpoint":
        scene["object.force_delay_ticks"] = 0.0
    if comm == "self-timed":
        scene["timing.ticks_per_packet"] = 1
        scene["coordination.credit_ticks"] = scene["network.one_way_delay_packets"] + int(rng.integers(1, 12))
    return {key: scene.get(key, value) for key, value in DEFAULTS.items() if not key.startswith("user.")}


def random_users(rng):
    """Push, pulse and sine of both users (user 2 always moves); pulse times off the tick grid, so that no pulse edge is a tie."""
    users = {}
    for peer in (1, 2):
        users |= {
            f"user.{peer}.push_n": short(rng.uniform(-0.2, 1.5)),
            f"user.{peer}.pulse_n": [0.0, short(rng.uniform(-1.0, 2.0))][rng.integers(2)],
            f"user.{peer}.pulse_s": round(float(rng.integers(5, 100)) * 0.002 + 0.0005, 6),
            f"user.{peer}.pulse_every_s": round(float(rng.integers(200, 1500)) * 0.002 + 0.000317, 6),
            f"user.{peer}.sine_n": [0.0, short(rng.uniform(0.1, 0.5))][rng.integers(2) if peer == 1 else 1],
            f"user.{peer}.sine_rad_per_s": spread(rng, 1.0, 30.0),
        }
    return users


def simulations():
    """Rows of simulations.csv: the scene and the four figures of `simulate`."""
    rng, rows = np.random.default_rng(20120), []
    while len(rows) < SIMULATIONS:
        scene = random_scene(rng, LAWS[len(rows) % len(LAWS)], 4)
        # Over 8 ms, whatever a packet period is.
        periods = 0.008 / (scene["timing.control_period_s"] * scene["timing.ticks_per_packet"])
        if spectral_radius(scene) ** periods < 0.999:
            scene |= random_users(rng)
            rows.append({**scene, **{key: float(value) for key, value in simulate(scene, DURATION_S).items()}})
    return rows


def spectra():
    """Rows of spectral.csv: the scene, its spectral radius, and whether it is stable (users do not matter)."""
    rng, rows = np.random.default_rng(19970), []
    while len(rows) < SPECTRA:
        scene = random_scene(rng, LAWS[len(rows) % len(LAWS)], 5)
        radius = spectral_radius(scene)
        other = spectral_radius(scene, phase=scene["timing.ticks_per_packet"] // 2 or 1)
        if abs(radius / other - 1) < 1e-11 and abs(radius - 1) > 1e-6:
            rows.append({**scene, "spectral_radius": float(radius), "stable": bool(radius < 1)})
    return rows


def write(name, rows):
    """One comment line, one header line, then the rows; booleans as in TOML, floats in full."""
    with open(HERE / name, "w", newline="") as file:
        file.write(f"{COMMAND}\n")
        table = csv.writer(file, lineterminator="\n")
        table.writerow(rows[0])
        table.writerows([str(v).lower() if isinstance(v, bool) else v for v in row.values()] for row in rows)


if __name__ == "__main__":
    write("simulations.csv", simulations())
    write("spectral.csv", spectra())
