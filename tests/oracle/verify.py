# SPDX-License-Identifier: MIT OR Apache-2.0
"""Prints every *checked* number of THEORY §3 and §4 beside the oracle's own, and checks the oracle's two methods on each other.

Run: OPENBLAS_NUM_THREADS=1 python3 tests/oracle/verify.py   (10 s; exit status 1 if a line marked `!` appears)
"""
import sys

import numpy as np

from model import DEFAULTS, FIG4, complete, crossings, lifted, plant, simulate, spectral_radius, user_force

COMM, DECODE, K_T, B_T = (f"coordination.{k}" for k in ("comm", "decode", "stiffness_n_per_m", "damping_n_s_per_m"))
K_LC, N_T, M_O, B = ("contact.stiffness_n_per_m", "network.one_way_delay_packets", "object.mass_kg",
                     "coordination.wave_impedance_n_s_per_m")
TAU_H, TAU_O, HOW = "device.force_delay_ticks", "object.force_delay_ticks", "object.integrator"
PUSH_TOGETHER = {"user.1.push_n": 1.0, "user.2.push_n": 1.0, "user.2.sine_n": 0.25, "user.2.sine_rad_per_s": 3.0}  # §5.2
# The matched line of THEORY §4. Unstable here: a forward-Euler object, an exact one with this B_T, an object delay of 1 tick
# (0.1 is still stable), and, for comm = wave only, K_T from 3320 to 5149 N/m.
MATCHED = {B: 40.0, M_O: 0.02, K_T: 1e5, B_T: 2.0, DECODE: "implicit", HOW: "semi-implicit", TAU_O: 0.0}
failures = 0


def line(what, got, theory, tolerance, known=False):
    """One line of the table; `!` when a value is further than the relative tolerance from THEORY's, `?` if that is known."""
    global failures
    got, theory = np.atleast_1d(got).astype(float), np.atleast_1d(theory).astype(float)
    good = got.shape == theory.shape and bool((np.abs(got / theory - 1) <= tolerance).all())
    failures += not good and not known
    show = lambda values: " ".join(f"{v:.5g}" for v in values) or "none"
    print(f"{' ' if good else '?' if known else '!'} {what:<58} got {show(got):<32} THEORY {show(theory)}", flush=True)


def two_methods_agree():
    """Largest relative difference of the x_o traces, simulate against the lifted matrices driven tick by tick."""
    worst, rng = 0.0, np.random.default_rng(1)
    for comm in ("power", "wave", "passive-wave", "passive-mean", "self-timed"):
        for decode in ("delayed", "implicit"):
            for how in ("forward-euler", "semi-implicit", "exact", "midpoint"):
                # The midpoint rule decodes in its solve, and only a self-timed line needs it.
                if how == "midpoint" and decode == "delayed" or how != "midpoint" and comm == "self-timed":
                    continue
                scene = {COMM: comm, DECODE: decode, HOW: how, K_T: 150.0, N_T: int(rng.integers(0, 5)),
                         TAU_H: rng.random(), TAU_O: rng.random(), "device.damping_n_s_per_m": 3.0,
                         "timing.ticks_per_packet": int(rng.integers(1, 10)),
                         **PUSH_TOGETHER, "user.1.pulse_n": 1.0, "user.1.pulse_s": 0.0105, "user.1.pulse_every_s": 0.1}
                if how == "midpoint":
                    scene[TAU_O] = 0.0
                if comm == "self-timed":
                    # From rest: until the first packet has come nothing is live, which no matrix says.
                    scene |= {"timing.ticks_per_packet": 1, N_T: 0, "coordination.credit_ticks": 4}
                s = complete(scene)
                trace = simulate(scene, 0.5, traces=True)["x_o"]
                names, exchange, tick = lifted(scene)
                kick = plant(0.1, 3.0, 0.001, s[TAU_H], "exact")[:, 2:].sum(1)
                state, other = np.zeros(len(names)), np.zeros_like(trace)
                for n in range(len(trace)):
                    if n % s["timing.ticks_per_packet"] == 0:
                        state = exchange @ state
                    other[n] = [state[names.index((i, "x_o"))] for i in (0, 1)]
                    state = tick @ state
                    for i in (0, 1):
                        state[[names.index((i, "x_h")), names.index((i, "v_h"))]] += kick * user_force(s, i + 1, n * 0.001)
                worst = max(worst, np.abs(trace - other).max() / np.abs(trace).max())
    return worst


def low_frequency(scene, same_way, rate=np.pi):
    """Apparent mass of the pair (kg; users push the same way: sum of F_LC over acceleration) or, users pushing together,
    compliance (mm/N: x_o1 - x_o2 over F_T). Phasors over whole periods of `rate` (rad/s) in the last half of 20 s."""
    users = {"user.1.sine_n": 1.0, "user.2.sine_n": -1.0 if same_way else 1.0,
             "user.1.sine_rad_per_s": rate, "user.2.sine_rad_per_s": rate}
    run = simulate({**scene, **users}, 20.0, traces=True)
    half = np.arange(10000, 20000)
    phasor = lambda signal: 2 * np.mean(signal[half] * np.exp(-1j * rate * 0.001 * half))
    if same_way:
        return (phasor(run["f_lc"].sum(1)) / (-rate**2 * phasor(run["x_o"].mean(1)))).real
    return 1e3 * (phasor(run["x_o"] @ [1, -1]) / phasor(run["f_t"] @ [-0.5, 0.5])).real


def transit(scene):
    """T of the closed form 2 m_O + b T, in s: transit, mean hold, one tick for u_out[n-1], and the filter's lag."""
    s = complete(scene)
    t_c, m = s["timing.control_period_s"], s["timing.ticks_per_packet"]
    pole = np.exp(-2 * np.pi * s["coordination.cutoff_hz"] * t_c)
    lag = pole / (1 - pole) if s[COMM] == "passive-wave" else 0.0
    return (s[N_T] * m + (m - 1) / 2 + 1 + lag) * t_c


def main():
    line("simulate against lifted: 1 + relative difference", 1 + two_methods_agree(), 1, 1e-9)
    first = lambda scene: [crossings({**scene, N_T: n}, K_T, 10, 13000)[0] for n in range(4)]
    line("Fig. 4 power, K_LC 500, n_t 0..3", first({**FIG4, COMM: "power"}), [2034, 390, 235, 169], 0.002)
    line("Fig. 4 wave", first({**FIG4, COMM: "wave"}), [3603, 3366, 3014, 2891], 0.0002)
    line("Fig. 4 wave n_t 1, all", crossings({**FIG4, COMM: "wave"}, K_T, 10, 13000), [3366, 5017, 9500], 0.01)
    stiff = first({**FIG4, COMM: "wave", K_LC: 1000.0})
    line("Fig. 4 wave, K_LC 1000, n_t 1..3", stiff[1:], [1600, 1780, 3300], 0.012)
    line("Fig. 4 wave, K_LC 1000, n_t 0 (1.88k for 1.81k?)", stiff[0], 1880, 0.012, known=True)
    line("Fig. 4 passive wave", first(FIG4), [10695, 10759, 10766, 10689], 0.0002)
    for tau, limit in ((1.0, 1850), (0.0, 5550)):
        scene = {**FIG4, K_T: 100.0, TAU_H: tau, TAU_O: tau}
        line(f"contact limit, passive, n_t 1, K_T 100, delay {tau:g}", crossings(scene, K_LC, 10, 9000), limit, 0.02)
    for comm, theory in (("power", [357]), ("wave", [1597, 5277, 9894]), ("passive-wave", [4401, 6061, 10850])):
        line(f"experiments' configuration, {comm}", crossings({COMM: comm}, K_T, 10, 13000), theory, 0.0003)
    for comm, stiffness, decoded, true in (("power", 310.0, 3.25, 3.24), ("wave", 1590.0, 0.638, 2.24),
                                           ("passive-wave", 10620.0, 0.0946, 1.78)):
        run = simulate({COMM: comm, K_T: stiffness, **PUSH_TOGETHER})
        line(f"§5.2 {comm} K_T {stiffness:g}: decoded, true (mm)", [run["decoded_mm"], run["true_mm"]], [decoded, true], 0.003)
    worst = max(spectral_radius({**FIG4, HOW: how, TAU_H: tau, TAU_O: 0.0, DECODE: "implicit", COMM: comm, N_T: n,
                                 K_LC: k_lc, K_T: k_t})
                for how in ("exact", "semi-implicit") for tau in (0.0, 1.0) for comm in ("wave", "passive-wave") for n in range(4)
                for k_lc in (600.0, 1000.0) for k_t in np.geomspace(10, 2e5, 30))
    line("implicit, no object delay, not forward Euler: 1 + excess", max(worst, 1), 1, 1e-9)
    for comm, true, in (("wave", 0.28), ("passive-wave", 0.37)):
        scene = {**MATCHED, COMM: comm}
        run = simulate({**scene, **PUSH_TOGETHER})
        line(f"matched line, {comm}: true (mm)", run["true_mm"], true, 0.03)
        line(f"matched line, {comm}: apparent mass (kg)", low_frequency(scene, True), 0.65, 0.05)
        print(f"    spectral radius {spectral_radius(scene):.5f}, compliance {low_frequency(scene, False):.4f} mm/N; closed forms: "
              f"mass {2 * scene[M_O] + scene[B] * transit(scene):.4f} kg, "
              f"compliance {1e3 * (transit(scene) / scene[B] + 2 / scene[K_T]):.4f} mm/N")
        heavy = {**scene, B: DEFAULTS[B], M_O: DEFAULTS[M_O]}
        print(f"    same settings at b 10, m_O 0.3: true {simulate({**heavy, **PUSH_TOGETHER})['true_mm']:.3f} mm, "
              f"apparent mass {low_frequency(heavy, True):.3f} kg")
    return failures > 0


if __name__ == "__main__":
    sys.exit(main())
