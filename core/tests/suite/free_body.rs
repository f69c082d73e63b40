//! A body that moves and turns at once: what an hour of it keeps, and the six equations that a tick must satisfy.

use cohold_core::num::{Motion, Scalar};
use cohold_core::object::free_body::{Flying, FreeBody, Wrench, at_point};
use cohold_core::object::port::Port;
use cohold_core::object::vector::{Moving, VectorPort};

const PERIOD_S: f64 = 1e-3;
const MASS_KG: f64 = 0.3;
/// kg·m², of a body of the size of a hand.
const INERTIA: [f64; 3] = [1e-3, 2e-3, 3.5e-3];

fn norm(parts: impl IntoIterator<Item = f64>) -> f64 {
    parts.into_iter().map(|part| part * part).sum::<f64>().sqrt()
}

fn flying<S: Scalar>(free: &FreeBody<S>, velocity: [f64; 3], turning: [f64; 3]) -> Flying<S> {
    let axes = velocity.map(|velocity| Motion { position: S::ZERO, velocity: S::from_f64(velocity) });
    Flying { moving: Moving::at(axes), turning: free.rotor.turning([1.0, 0.2, -0.1, 0.3], turning) }
}

/// Largest drifts of energy, of momentum and of angular momentum about the origin, as the body shows them, relative; and of its path, m.
fn drifts<S: Scalar>(ticks: u32) -> [f64; 4] {
    let free = FreeBody::<S>::new(MASS_KG, 0.0, INERTIA, PERIOD_S);
    let velocity = [0.01, -0.02, 0.015];
    let mut state = flying(&free, velocity, [0.02, 10.0, 0.01]);
    let shown = |state: &Flying<S>| {
        let body = free.rotor.velocity(&state.turning).map(S::to_f64);
        let spin =
            state.turning.rotation().map(|row| (0..3).map(|at| row[at].to_f64() * INERTIA[at] * body[at]).sum::<f64>());
        let momentum = state.moving.velocity().map(|velocity| MASS_KG * velocity.to_f64());
        let [x, y, z] = state.moving.axes.map(|axis| axis.position.to_f64());
        let [px, py, pz] = momentum;
        (momentum, [spin[0] + y * pz - z * py, spin[1] + z * px - x * pz, spin[2] + x * py - y * px])
    };
    let (energy, (momentum, whole)) = (free.energy_j(&state).to_f64(), shown(&state));
    let off = |now: [f64; 3], before: [f64; 3]| norm((0..3).map(|at| now[at] - before[at])) / norm(before);
    let mut worst = [0.0_f64; 4];
    for tick in 1..=ticks {
        free.step(&mut state, &Wrench::default());
        if tick % 100 == 0 {
            let (now_momentum, now_whole) = shown(&state);
            let path = velocity.map(|velocity| velocity * PERIOD_S * f64::from(tick));
            let there = state.moving.axes.map(|axis| axis.position.to_f64());
            let now = [
                (free.energy_j(&state).to_f64() / energy - 1.0).abs(),
                off(now_momentum, momentum),
                off(now_whole, whole),
                norm((0..3).map(|at| there[at] - path[at])),
            ];
            worst = std::array::from_fn(|at| worst[at].max(now[at]));
        }
    }
    worst
}

#[test]
fn an_hour_of_free_tumbling_keeps_energy_and_momenta() {
    let [energy, momentum, whole, path] = drifts::<f64>(3_600_000);
    println!(
        "f64, an hour: energy {energy:.1e}, momentum {momentum:.1e}, angular momentum {whole:.1e}, path {path:.1e} m"
    );
    assert!(
        energy < 1e-9 && momentum < 1e-12 && whole < 1e-9 && path < 1e-9,
        "{energy:e} {momentum:e} {whole:e} {path:e}"
    );
}

#[test]
fn a_minute_of_free_tumbling_in_f32() {
    let [energy, momentum, whole, path] = drifts::<f32>(60_000);
    println!(
        "f32, a minute: energy {energy:.1e}, momentum {momentum:.1e}, angular momentum {whole:.1e}, path {path:.1e} m"
    );
    assert!(
        energy < 1e-5 && momentum < 1e-6 && whole < 1e-4 && path < 1e-5,
        "{energy:e} {momentum:e} {whole:e} {path:e}"
    );
}

/// Numbers in [-1, 1) from a linear congruential generator.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.0) / f64::from(1_u32 << 31) - 1.0
    }

    fn three(&mut self) -> [f64; 3] {
        [(); 3].map(|()| self.next())
    }
}

/// Dampers, and pushes, at points of space that move with the body's centre.
fn ports(random: &mut Random, pushes: f64) -> Wrench<f64> {
    (0..3).fold(Wrench::default(), |sum, _| {
        let unit = random.three();
        let port = Port { force: pushes * random.next(), impedance: 20.0 * random.next().max(0.0) };
        let arm = random.three().map(|part| 0.1 * part);
        sum + at_point(arm, &VectorPort::along(unit, port))
    })
}

/// Force and torque are what the ports give for the mean velocities, momenta change by them, and energy by their work: the block
/// elimination has solved all six equations.
#[test]
fn a_tick_satisfies_all_six_equations() {
    let free = FreeBody::<f64>::new(MASS_KG, 0.0, INERTIA, PERIOD_S);
    let mut random = Random(7);
    let mut coupled = 0.0_f64;
    for _ in 0..300 {
        let mut state = flying(&free, random.three(), random.three().map(|part| 20.0 * part));
        for _ in 0..20 {
            let port = ports(&mut random, 5.0);
            let (before, energy) = (state, free.energy_j(&state));
            let flown = free.step(&mut state, &port);
            let [vx, vy, vz] = flown.mean_velocity;
            let [wx, wy, wz] = flown.turned.mean_velocity;
            let wrench = port.at([vx, vy, vz, wx, wy, wz]);
            for axis in 0..3 {
                let (was, is) = (before.moving.axes[axis].velocity, state.moving.axes[axis].velocity);
                assert!((MASS_KG * (is - was) / PERIOD_S - wrench[axis]).abs() < 1e-9, "{wrench:?}");
                let (was, is) = (before.turning.momentum[axis], state.turning.momentum[axis]);
                assert!(((is - was) / PERIOD_S - wrench[3 + axis]).abs() < 1e-9, "{wrench:?}");
            }
            let work: f64 = wrench.iter().zip([vx, vy, vz, wx, wy, wz]).map(|(force, moved)| force * moved).sum();
            let gained = free.energy_j(&state) - energy;
            assert!(
                (gained - PERIOD_S * work).abs() < 1e-12 * energy.max(1.0),
                "{gained:e} J of {:e}",
                PERIOD_S * work
            );
            coupled = coupled.max(port.impedance[0][4].abs());
        }
    }
    assert!(coupled > 0.1, "nothing couples moving with turning: {coupled}");
}

#[test]
fn dampers_at_any_point_only_take_energy() {
    let free = FreeBody::<f64>::new(MASS_KG, 0.1, INERTIA, PERIOD_S);
    for seed in 0..100 {
        let mut random = Random(seed);
        let mut state = flying(&free, random.three(), random.three().map(|part| 20.0 * part));
        let mut before = free.energy_j(&state);
        let began = before;
        for tick in 0..300 {
            free.step(&mut state, &ports(&mut random, 0.0));
            let now = free.energy_j(&state);
            assert!(now <= before + 1e-14 * began, "seed {seed}, tick {tick}: {now} after {before}");
            before = now;
        }
        assert!(before < began, "{seed}");
    }
}
