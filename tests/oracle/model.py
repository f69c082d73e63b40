# SPDX-License-Identifier: MIT OR Apache-2.0
"""Independent oracle: two peers, one shared virtual object (THEORY §1-§4), in Python and NumPy.

Two methods that share only the parameters: `simulate` runs the tick order of THEORY §2 on scalars; `monodromy`
writes each tick as a matrix and multiplies one packet period together. SI units; symbols as in THEORY's table.
A scene is a flat dict of DESIGN's dotted keys; what is left out takes DEFAULTS (the cooperation paper's §5).

Conventions, where THEORY §2 leaves a choice (n is the tick):
* At n mod M = 0 packets cross first. Wave and passive wave send the u_out or y stored by tick n-1; power sends
  x_o[n], v_o[n]. n_t = 0 is received at that very tick, by both peers. The queue starts empty: all values are 0.
* `delayed`: v_d[n] = (sqrt(2b) u_in - F_T[n-1])/b and x_d[n] = x_d[n-1] + T_c v_d[n-1]: the OLD speed moves x_d (with the new
  one the limits are others), and F_T[n-1] is used whatever the object delay is. `implicit`: THEORY's closed form. In both,
  F_T[n] = K_T (x_d - x_o) + B_T (v_d - v_o), and u_out[n] uses this F_T[n] and this v_d[n]. Power: x_d, v_d are the held packet,
  `decode` has no effect.
* The device is always exact ZOH, and only -F_LC is delayed; the user force of tick n acts from n to n+1, undelayed.
* The object delay tau applies to the whole F_LC + F_T; its damping b_O is not delayed.
* Delay "1 tick" in THEORY §3, §4 means device and object both (force_delay_ticks = 1.0).
* `midpoint` (THEORY §7): the four equations of a tick (object, contact, spring, line or held packet) are solved as a linear system
  for the mean velocities v of x_o and w of x_d and the two forces, which act through the tick. Needs `implicit`, tau_o = 0.
* `passive-mean`: sent is the mean of the M waves since the last packet. `self-timed` (THEORY §8): sent are the live ticks and
  T_c times the sum of their waves; emitted is the mean of what is outstanding; nothing before the first packet has come. As
  matrices only with M = 1 and credit > n_t, when credit - n_t samples are outstanding at every tick.
* Figures of tick n are taken before it advances: x_o[n], and x_d[n] as F_T[n] used it; "last half" is n >= N // 2;
  sd is the population's (ddof = 0). Two-sided contact only.
"""
import math

import numpy as np

DEFAULTS = {
    "timing.control_period_s": 0.001, "timing.ticks_per_packet": 8,
    "device.mass_kg": 0.1, "device.damping_n_s_per_m": 1.0, "device.force_delay_ticks": 1.0,
    "contact.stiffness_n_per_m": 1000.0, "contact.damping_n_s_per_m": 2.0, "contact.one_sided": False,
    "object.mass_kg": 0.3, "object.damping_n_s_per_m": 0.0, "object.force_delay_ticks": 1.0,
    "object.integrator": "forward-euler",
    "coordination.comm": "passive-wave", "coordination.decode": "delayed",
    "coordination.stiffness_n_per_m": 10620.0, "coordination.damping_n_s_per_m": 2.0,
    "coordination.wave_impedance_n_s_per_m": 10.0, "coordination.cutoff_hz": 60.0,
    "coordination.credit_ticks": 0,
    "network.one_way_delay_packets": 1,
}
USER_KEYS = ("push_n", "pulse_n", "pulse_s", "pulse_every_s", "sine_n", "sine_rad_per_s")
DEFAULTS.update({f"user.{peer}.{key}": 0.0 for peer in (1, 2) for key in USER_KEYS})

# Fig. 4 of the cooperation paper as THEORY §3 takes it (K_LC = 500).
FIG4 = {"object.mass_kg": 0.6, "contact.stiffness_n_per_m": 500.0, "object.integrator": "exact"}


def complete(scene):
    """The scene with its defaults; raises KeyError at an unknown key, ValueError at an unknown word."""
    unknown = set(scene) - set(DEFAULTS)
    if unknown:
        raise KeyError(f"unknown scene keys {sorted(unknown)}")
    full = {**DEFAULTS, **scene}
    for key, words in (("coordination.comm", ("power", "wave", "passive-wave", "passive-mean", "self-timed")),
                       ("coordination.decode", ("delayed", "implicit")),
                       ("object.integrator", ("forward-euler", "semi-implicit", "exact", "midpoint"))):
        if full[key] not in words:
            raise ValueError(f"{key} = {full[key]!r}, expected one of {words}")
    if full["contact.one_sided"]:
        raise ValueError("contact.one_sided = True: the oracle has two-sided contact only")
    midpoint = full["object.integrator"] == "midpoint"
    if midpoint and (full["coordination.decode"], full["object.force_delay_ticks"]) != ("implicit", 0.0):
        raise ValueError("midpoint needs decode = implicit and object.force_delay_ticks = 0")
    if full["coordination.comm"] == "self-timed" and not (midpoint and full["coordination.credit_ticks"] > 0):
        raise ValueError("self-timed needs midpoint and, here, a stated credit")
    return full


def expm(a):
    """Matrix exponential: Taylor series after halving the norm below 1/8 (18 terms reach 1e-30)."""
    halvings = max(0, math.ceil(math.log2(max(np.abs(a).sum(1).max(), 1e-30) * 8)))
    a = a / 2.0 ** halvings
    term = total = np.eye(len(a))
    for k in range(1, 19):
        term = term @ a / k
        total = total + term
    for _ in range(halvings):
        total = total @ total
    return total


def plant(mass, damping, t_c, tau, integrator):
    """One tick of m x'' + b x' = F: returns the 2x4 matrix [x, v, F_old, F_new] -> [x, v].

    F_old acts for tau * t_c, F_new for the rest (exact), or their weighted mean acts all along (the Euler forms).
    """
    if integrator == "exact":
        a = np.array([[0, 1, 0], [0, -damping / mass, 1 / mass], [0, 0, 0]])
        first, rest = expm(a * tau * t_c), expm(a * (1 - tau) * t_c)
        return np.column_stack([rest[:2, :2] @ first[:2, :2], rest[:2, :2] @ first[:2, 2], rest[:2, 2]])
    accel = np.array([0, -damping, tau, 1 - tau]) / mass
    new_v = np.array([0, 1, 0, 0]) + t_c * accel
    moving_v = np.array([0, 1, 0, 0]) if integrator == "forward-euler" else new_v
    return np.vstack([np.array([1, 0, 0, 0]) + t_c * moving_v, new_v])


def midway(s, wave):
    """The equations of one midpoint tick as a matrix: unknowns v, w, F_LC, F_T; rows object, contact, spring, line (or w held).

    Right sides: 2 m_O/T_c v_o; K_LC (x_h - x_o) + B_LC v_h; K_T (x_d - x_o); sqrt(2b) u_in, or for power the held v_d.
    In power x_d does not move through the tick, so that w enters the spring as B_T v_d only.
    """
    t_c = s["timing.control_period_s"]
    inertia = 2 * s["object.mass_kg"] / t_c
    z_c = s["contact.stiffness_n_per_m"] * t_c / 2 + s["contact.damping_n_s_per_m"]
    b_t = s["coordination.damping_n_s_per_m"]
    z_t = s["coordination.stiffness_n_per_m"] * t_c / 2 + b_t
    b = s["coordination.wave_impedance_n_s_per_m"]
    return np.array([[inertia + s["object.damping_n_s_per_m"], 0, -1, -1],
                     [z_c, 0, 1, 0],
                     [z_t, -(z_t if wave else b_t), 0, 1],
                     [0, b, 0, 1] if wave else [0, 1, 0, 0]])


def user_force(s, peer, t):
    """Force of one user at time t (s), in N along +x. Ties of the pulse are decided as in exact arithmetic (1 ns guard)."""
    push, pulse, width, every, sine, rate = (s[f"user.{peer}.{key}"] for key in USER_KEYS)
    force = push + sine * math.sin(rate * t)
    if pulse and every > 0 and math.fmod(t + 1e-9, every) < width:
        force += pulse
    return force if peer == 1 else -force


def simulate(scene, duration_s=20.0, traces=False):
    """Time-domain run. Returns decoded_mm, true_mm, force_mean_n, force_sd_n and, if asked, traces (THEORY §4)."""
    s = complete(scene)
    t_c, m = s["timing.control_period_s"], s["timing.ticks_per_packet"]
    k_lc, b_lc = s["contact.stiffness_n_per_m"], s["contact.damping_n_s_per_m"]
    k_t, b_t = s["coordination.stiffness_n_per_m"], s["coordination.damping_n_s_per_m"]
    comm, implicit = s["coordination.comm"], s["coordination.decode"] == "implicit"
    b, n_t = s["coordination.wave_impedance_n_s_per_m"], s["network.one_way_delay_packets"]
    root = math.sqrt(2 * b)
    pole = math.exp(-2 * math.pi * s["coordination.cutoff_hz"] * t_c)
    rows = lambda table, i, tau, how: plant(s[f"{table}.mass_kg"], s[f"{table}.damping_n_s_per_m"], t_c, tau, how)[i].tolist()
    tau_h, tau_o = s["device.force_delay_ticks"], s["object.force_delay_ticks"]
    dev = [rows("device", i, tau_h, "exact") for i in (0, 1)]
    midpoint = s["object.integrator"] == "midpoint"
    obj = None if midpoint else [rows("object", i, tau_o, s["object.integrator"]) for i in (0, 1)]
    solve = np.linalg.inv(midway(s, comm != "power")) if midpoint else None
    timed, mean = comm == "self-timed", comm == "passive-mean"
    inertia = 2 * s["object.mass_kg"] / t_c
    # A self-timed line: ticks and wave integral sent; of the other's, what was heard and what was emitted.
    live, integral, heard, emitted = [0, 0], [0.0, 0.0], [None, None], [(0, 0.0), (0, 0.0)]
    nothing = (0.0, 0.0) if comm in ("power", "self-timed") else 0.0
    x_h, v_h, x_o, v_o, x_d, v_d = ([0.0, 0.0] for _ in range(6))
    f_lc_old, f_o_old, f_t, u_out, y = ([0.0, 0.0] for _ in range(5))
    held, wire = [nothing, nothing], [[nothing] * n_t, [nothing] * n_t]
    ticks = round(duration_s / t_c)
    keep = {name: np.zeros((ticks, 2)) for name in ("x_h", "x_o", "v_o", "x_d", "f_lc", "f_t")}

    for n in range(ticks):
        if n % m == 0:
            for i in (0, 1):
                wire[i].append((x_o[i], v_o[i]) if comm == "power" else (live[i], integral[i]) if timed
                               else u_out[i] if comm == "wave" else y[i])
                if mean:
                    y[i] = 0.0
            for i in (0, 1):
                held[i] = wire[1 - i].pop(0)
                if timed and n >= n_t * m:
                    heard[i] = (held[i][0] + s["coordination.credit_ticks"], held[i][1])
        for i in (0, 1):
            f_lc = k_lc * (x_h[i] - x_o[i]) + b_lc * (v_h[i] - v_o[i])
            before_d, before_o, stands = x_d[i], x_o[i], False
            if comm == "power":
                x_d[i], v_d[i] = held[i]
                before_d = x_d[i]
            if midpoint:
                u_in = held[i]
                if timed:
                    samples = 0 if heard[i] is None else heard[i][0] - emitted[i][0]
                    stands = samples <= 0
                    u_in = 0.0 if stands else (heard[i][1] - emitted[i][1]) / (samples * t_c)
                equations = solve
                if stands:
                    wall = midway(s, True)
                    wall[3] = [0, 1, 0, 0]
                    equations = np.linalg.inv(wall)
                last = v_d[i] if comm == "power" else root * u_in
                right = [inertia * v_o[i], k_lc * (x_h[i] - x_o[i]) + b_lc * v_h[i], k_t * (before_d - x_o[i]), last]
                v_mean, w, f_lc, f_t[i] = equations @ right
                if comm != "power":
                    v_d[i] = w
                    x_d[i] += t_c * w
            elif comm != "power":
                if implicit:
                    v_d[i] = (root * held[i] - k_t * (x_d[i] - x_o[i]) + b_t * v_o[i]) / (b + b_t + k_t * t_c)
                    x_d[i] += t_c * v_d[i]
                else:
                    x_d[i] += t_c * v_d[i]
                    v_d[i] = (root * held[i] - f_t[i]) / b
            if not midpoint:
                f_t[i] = k_t * (x_d[i] - x_o[i]) + b_t * (v_d[i] - v_o[i])
                before_d = x_d[i]
            u_out[i] = (b * v_d[i] - f_t[i]) / root
            y[i] = y[i] + u_out[i] / m if mean else pole * y[i] + (1 - pole) * u_out[i]
            if timed and not stands:
                emitted[i] = (emitted[i][0] + 1, emitted[i][1] + t_c * u_in)
                live[i], integral[i] = live[i] + 1, integral[i] + t_c * u_out[i]
            keep["x_h"][n, i], keep["x_o"][n, i], keep["v_o"][n, i] = x_h[i], x_o[i], v_o[i]
            keep["x_d"][n, i], keep["f_lc"][n, i], keep["f_t"][n, i] = before_d, f_lc, f_t[i]
            user, f_o = user_force(s, i + 1, n * t_c), f_lc + f_t[i]
            x_h[i], v_h[i] = (r[0] * x_h[i] + r[1] * v_h[i] + r[2] * (user - f_lc_old[i]) + r[3] * (user - f_lc) for r in dev)
            if midpoint:
                x_o[i], v_o[i] = before_o + t_c * v_mean, 2 * v_mean - v_o[i]
            else:
                x_o[i], v_o[i] = (r[0] * x_o[i] + r[1] * v_o[i] + r[2] * f_o_old[i] + r[3] * f_o for r in obj)
            f_lc_old[i], f_o_old[i] = f_lc, f_o

    half = slice(ticks // 2, None)
    result = {
        "decoded_mm": 1e3 * np.abs(keep["x_o"] - keep["x_d"])[half, 1].mean(),
        "true_mm": 1e3 * np.abs(keep["x_o"][half, 0] - keep["x_o"][half, 1]).mean(),
        "force_mean_n": keep["f_t"][half, 1].mean(),
        "force_sd_n": keep["f_t"][half, 1].std(),
    }
    return {**result, **keep} if traces else result


def lifted(scene):
    """State names, exchange matrix and tick matrix. Per peer i: plant, decode, last forces, u_out, y, held packet; per
    sender i the packets on the wire, w1 the youngest."""
    s = complete(scene)
    t_c, comm, n_t = s["timing.control_period_s"], s["coordination.comm"], s["network.one_way_delay_packets"]
    parts = ("x", "v") if comm == "power" else ("u",)
    local = ["x_h", "v_h", "x_o", "v_o", "x_d", "v_d", "f_lc", "f_o", "f_t", "u_out", "y", "r"]
    local += [f"held_{p}" for p in parts] + [f"w{k}_{p}" for k in range(1, n_t + 1) for p in parts]
    names = [(i, name) for i in (0, 1) for name in local]
    at = {name: k for k, name in enumerate(names)}
    eye = np.eye(len(names))
    exchange, tick = eye.copy(), eye.copy()

    source = {"power": {"x": "x_o", "v": "v_o"}, "wave": {"u": "u_out"}, "passive-wave": {"u": "y"},
              "passive-mean": {"u": "y"}, "self-timed": {"u": "y"}}[comm]
    for i in (0, 1):
        for p in parts:
            sent = [eye[at[i, source[p]]]] + [eye[at[i, f"w{k}_{p}"]] for k in range(1, n_t + 1)]
            for k in range(1, n_t + 1):
                exchange[at[i, f"w{k}_{p}"]] = sent[k - 1]
            exchange[at[1 - i, f"held_{p}"]] = sent[n_t]
        if comm in ("passive-mean", "self-timed"):
            exchange[at[i, "y"]] = 0.0

    k_lc, b_lc = s["contact.stiffness_n_per_m"], s["contact.damping_n_s_per_m"]
    k_t, b_t = s["coordination.stiffness_n_per_m"], s["coordination.damping_n_s_per_m"]
    b = s["coordination.wave_impedance_n_s_per_m"]
    pole = math.exp(-2 * math.pi * s["coordination.cutoff_hz"] * t_c)
    midpoint, m, timed = s["object.integrator"] == "midpoint", s["timing.ticks_per_packet"], comm == "self-timed"
    device, svo = (None if how == "midpoint" else
                   plant(s[f"{t}.mass_kg"], s[f"{t}.damping_n_s_per_m"], t_c, s[f"{t}.force_delay_ticks"], how)
                   for t, how in (("device", "exact"), ("object", s["object.integrator"])))
    solve = np.linalg.inv(midway(s, comm != "power")) if midpoint else None
    samples = s["coordination.credit_ticks"] - n_t
    if timed and (m != 1 or samples < 1):
        raise ValueError("a self-timed line is one matrix only with a packet a tick and a credit above the delay")
    for i in (0, 1):
        row = {name: eye[at[i, name]] for name in local}
        f_lc = k_lc * (row["x_h"] - row["x_o"]) + b_lc * (row["v_h"] - row["v_o"])
        r = 0 * row["r"]
        if comm == "power":
            x_d, v_d = row["held_x"], row["held_v"]
        else:
            u_in = row["held_u"]
            if timed:
                # What came with this tick's packet joins what was left; one of so many samples comes out.
                outstanding = row["r"] + row["held_u"]
                u_in, r = outstanding / (samples * t_c), outstanding * (1 - 1 / samples)
            incoming = math.sqrt(2 * b) * u_in
        if midpoint:
            x_d = row["held_x"] if comm == "power" else row["x_d"]
            v_mean, w, f_lc, f_t = solve @ np.vstack([
                2 * s["object.mass_kg"] / t_c * row["v_o"],
                k_lc * (row["x_h"] - row["x_o"]) + b_lc * row["v_h"],
                k_t * (x_d - row["x_o"]),
                row["held_v"] if comm == "power" else incoming])
            if comm != "power":
                x_d, v_d = row["x_d"] + t_c * w, w
            x_o, v_o = row["x_o"] + t_c * v_mean, 2 * v_mean - row["v_o"]
        elif comm != "power":
            if s["coordination.decode"] == "delayed":
                v_d = (incoming - row["f_t"]) / b
                x_d = row["x_d"] + t_c * row["v_d"]
            else:
                v_d = (incoming - k_t * (row["x_d"] - row["x_o"]) + b_t * row["v_o"]) / (b + b_t + k_t * t_c)
                x_d = row["x_d"] + t_c * v_d
        if not midpoint:
            f_t = k_t * (x_d - row["x_o"]) + b_t * (v_d - row["v_o"])
            x_o, v_o = svo @ np.vstack([row["x_o"], row["v_o"], row["f_o"], f_lc + f_t])
        u_out = (b * v_d - f_t) / math.sqrt(2 * b)
        x_h, v_h = device @ np.vstack([row["x_h"], row["v_h"], -row["f_lc"], -f_lc])
        y = {"passive-mean": row["y"] + u_out / m, "self-timed": row["y"] + t_c * u_out}.get(comm, pole * row["y"] + (1 - pole) * u_out)
        new = {"x_h": x_h, "v_h": v_h, "x_o": x_o, "v_o": v_o, "x_d": x_d, "v_d": v_d, "f_lc": f_lc, "f_o": f_lc + f_t, "f_t": f_t,
               "u_out": u_out, "y": y, "r": r}
        for name, value in new.items():
            tick[at[i, name]] = value
    return names, exchange, tick


def monodromy(scene, phase=0):
    """The lifted map over one packet period, from just before one exchange to just before the next; `phase` > 0 starts that
    many ticks earlier: the same spectrum with other rounding."""
    _, exchange, tick = lifted(scene)
    power = lambda ticks: np.linalg.matrix_power(tick, ticks)
    return power(complete(scene)["timing.ticks_per_packet"] - phase) @ exchange @ power(phase)


def spectral_radius(scene, phase=0):
    """Largest |eigenvalue| but the rest modes, which are divided out by their known eigenvectors (THEORY §3).

    A translation moves every position by the same amount and nothing else: the pair's in power (packets carry positions),
    each peer's own in the wave forms. The rest of the spectrum is that of the map on the quotient space.
    """
    names, _, _ = lifted(scene)
    position = np.array([name[:2] == "x_" or name.endswith("_x") for _, name in names])
    peer = np.array([i for i, _ in names])
    power = complete(scene)["coordination.comm"] == "power"
    rest = np.column_stack([position] if power else [position & (peer == 0), position & (peer == 1)]).astype(float)
    period = monodromy(scene, phase)
    scale = np.abs(period).max()
    if not np.abs(period @ rest - rest).max() <= 1e-9 * scale:
        raise ArithmeticError("a translation is not a rest mode of this scene")
    basis = np.linalg.qr(rest, mode="complete")[0][:, rest.shape[1]:]
    return float(np.abs(np.linalg.eigvals(basis.T @ period @ basis)).max())


def crossings(scene, key, a, b, points=400, tolerance=1e-7):
    """Every value of `key` in [a, b] where stability changes: scan of `points` intervals, then bisection to `tolerance`
    (relative). A pocket narrower than one interval can be missed."""
    excess = lambda value: spectral_radius({**scene, key: value}) - 1
    grid = np.linspace(a, b, points + 1)
    signs = [excess(value) > 0 for value in grid]
    found = []
    for low, high, was, now in zip(grid, grid[1:], signs, signs[1:]):
        if was == now:
            continue
        while high - low > tolerance * abs(high):
            middle = (low + high) / 2
            low, high = (middle, high) if (excess(middle) > 0) == was else (low, middle)
        found.append(float(low + high) / 2)
    return found
