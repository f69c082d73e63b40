//! The free rigid body against closed forms: what is kept in an hour at 1 kHz, and how fast it turns.

use cohold_core::num::Scalar;
use cohold_core::object::rigid::{Rotor, TorquePort, Turning};

/// kg·m², of a body of the size of a hand.
const INERTIA: [f64; 3] = [1e-3, 2e-3, 3.5e-3];
/// Nearly about the intermediate axis: it tumbles.
const TUMBLING: [f64; 3] = [0.02, 10.0, 0.01];

fn norm(parts: impl IntoIterator<Item = f64>) -> f64 {
    parts.into_iter().map(|part| part * part).sum::<f64>().sqrt()
}

/// Momentum in space from the body's orientation and velocity, not from what is stored.
fn momentum<S: Scalar>(rotor: &Rotor<S>, state: &Turning<S>, inertia: [f64; 3]) -> [f64; 3] {
    let velocity = rotor.velocity(state).map(S::to_f64);
    state.rotation().map(|row| (0..3).map(|axis| row[axis].to_f64() * inertia[axis] * velocity[axis]).sum())
}

/// Largest drifts of energy, of momentum as the body shows it, and of the quaternion's norm, relative; and how often it flipped.
fn drifts<S: Scalar>(ticks: u32, period_s: f64) -> ([f64; 3], u32) {
    let rotor = Rotor::<S>::new(INERTIA, period_s);
    let mut state = rotor.turning([1.0, 0.0, 0.0, 0.0], TUMBLING);
    let (stored, began) = (state.momentum, momentum(&rotor, &state, INERTIA));
    let energy = rotor.energy_j(&state).to_f64();
    let (mut worst, mut flips, mut up) = ([0.0_f64; 3], 0, true);
    for tick in 0..ticks {
        rotor.coast(&mut state);
        let now_up = rotor.velocity(&state)[1] > S::ZERO;
        flips += u32::from(now_up != up);
        up = now_up;
        if tick % 100 == 0 {
            let there = momentum(&rotor, &state, INERTIA);
            let moved = norm((0..3).map(|axis| there[axis] - began[axis])) / norm(began);
            let changed = (rotor.energy_j(&state).to_f64() / energy - 1.0).abs();
            let long = (norm(state.orientation.map(S::to_f64)) - 1.0).abs();
            worst = [worst[0].max(changed), worst[1].max(moved), worst[2].max(long)];
        }
    }
    assert_eq!(state.momentum, stored, "nothing turned it");
    (worst, flips)
}

#[test]
fn an_hour_of_tumbling_keeps_energy_and_momentum() {
    let ([energy, momentum, norm], flips) = drifts::<f64>(3_600_000, 1e-3);
    println!("f64: energy {energy:.1e}, momentum {momentum:.1e}, norm {norm:.1e}, {flips} flips");
    assert!(energy < 1e-9 && momentum < 1e-9 && norm < 1e-12, "{energy:e} {momentum:e} {norm:e}");
    assert!(flips > 1000, "it did not tumble: {flips}");
}

#[test]
fn a_minute_of_tumbling_in_f32() {
    let ([energy, momentum, norm], flips) = drifts::<f32>(60_000, 1e-3);
    println!("f32: energy {energy:.1e}, momentum {momentum:.1e}, norm {norm:.1e}, {flips} flips");
    assert!(energy < 1e-5 && momentum < 1e-5 && norm < 1e-6, "{energy:e} {momentum:e} {norm:e}");
}

/// The complete elliptic integral of the first kind, by the arithmetic-geometric mean.
fn elliptic(k_squared: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - k_squared).sqrt());
    for _ in 0..40 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    core::f64::consts::FRAC_PI_2 / a
}

/// How long the angular velocity takes to come back in the body (Landau & Lifshitz, Mechanics, §37), s.
fn polhode_s([i1, i2, i3]: [f64; 3], [w1, w2, w3]: [f64; 3]) -> f64 {
    let twice_energy = i1 * w1 * w1 + i2 * w2 * w2 + i3 * w3 * w3;
    let square = norm([i1 * w1, i2 * w2, i3 * w3]).powi(2);
    assert!(square > twice_energy * i2, "about the axis of the largest inertia");
    let rate = (i3 - i2) * (square - twice_energy * i1);
    let k_squared = (i2 - i1) * (twice_energy * i3 - square) / rate;
    4.0 * elliptic(k_squared) * (i1 * i2 * i3 / rate).sqrt()
}

/// The same from a run: between the second component's first and last ascents through 0, which are interpolated.
fn measured_s(velocity: [f64; 3], period_s: f64, duration_s: f64) -> f64 {
    let rotor = Rotor::<f64>::new(INERTIA, period_s);
    let mut state = rotor.turning([0.5, -0.5, 0.5, 0.5], velocity);
    let (mut ascents, mut before) = (Vec::new(), velocity);
    for tick in 0..(duration_s / period_s) as u32 {
        let mean = rotor.coast(&mut state);
        let now = rotor.velocity(&state);
        if before[1] < 0.0 && now[1] >= 0.0 {
            // Of a cubic that has both values and both slopes (Euler's equations), the root by Newton's method.
            let slope = |w: [f64; 3]| (INERTIA[2] - INERTIA[0]) / INERTIA[1] * w[2] * w[0];
            let (p0, p1, m0, m1) = (before[1], now[1], slope(before) * period_s, slope(now) * period_s);
            let at = |t: f64| {
                let (t2, t3) = (t * t, t * t * t);
                (2.0 * t3 - 3.0 * t2 + 1.0) * p0
                    + (t3 - 2.0 * t2 + t) * m0
                    + (3.0 * t2 - 2.0 * t3) * p1
                    + (t3 - t2) * m1
            };
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                (low, high) = if at(middle) < 0.0 { (middle, high) } else { (low, middle) };
            }
            ascents.push((f64::from(tick) + low) * period_s);
        }
        assert!(mean.torque == [0.0; 3]);
        before = now;
    }
    let turns = ascents.len() - 1;
    (ascents[turns] - ascents[0]) / turns as f64
}

#[test]
fn the_polhode_takes_the_time_of_jacobis_solution() {
    let velocity = [2.0, 3.0, 8.0];
    let exact = polhode_s(INERTIA, velocity);
    let [coarse, fine] = [2e-3, 1e-3].map(|period_s| measured_s(velocity, period_s, 60.0));
    println!("polhode: exact {exact} s, at 2 ms {coarse}, at 1 ms {fine}");
    // Of second order: half the step, a quarter of the error; and what is left of that is far less.
    let ratio = (coarse - exact) / (fine - exact);
    assert!((ratio - 4.0).abs() < 0.02, "{ratio}");
    let extrapolated = fine + (fine - coarse) / 3.0;
    assert!((extrapolated / exact - 1.0).abs() < 1e-9, "{extrapolated} {exact}");
}

/// About its momentum, rad/s: how fast the axis of a symmetric top goes round, which keeps its angle to it.
fn precession(inertia: [f64; 3], velocity: [f64; 3], period_s: f64) -> f64 {
    let rotor = Rotor::<f64>::new(inertia, period_s);
    let mut state = rotor.turning([1.0, 0.0, 0.0, 0.0], velocity);
    let momentum = state.momentum;
    let axis = |state: &Turning<f64>| state.rotation().map(|row| row[2]);
    let along = |vector: [f64; 3]| (0..3).map(|at| vector[at] * momentum[at]).sum::<f64>() / norm(momentum);
    let began = along(axis(&state));
    let ticks = 10_000;
    let mut angle = 0.0;
    for _ in 0..ticks {
        let before = axis(&state);
        rotor.coast(&mut state);
        let after = axis(&state);
        assert!((along(after) - began).abs() < 1e-13, "it nutates");
        // The angle between the parts of both that lie across the momentum.
        let across = |vector: [f64; 3]| {
            let part = along(vector) / norm(momentum);
            [0, 1, 2].map(|at| vector[at] - part * momentum[at])
        };
        let (a, b) = (across(before), across(after));
        let cosine: f64 = (0..3).map(|at| a[at] * b[at]).sum();
        let sine = norm([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]);
        angle += sine.atan2(cosine);
    }
    angle / (f64::from(ticks) * period_s)
}

#[test]
fn a_symmetric_top_precesses_with_its_momentum_over_its_inertia() {
    let (inertia, velocity) = ([2e-3, 2e-3, 1e-3], [0.0, 3.0, 20.0]);
    let exact = norm([0, 1, 2].map(|axis| inertia[axis] * velocity[axis])) / inertia[0];
    let [coarse, fine] = [2e-3, 1e-3].map(|period_s| precession(inertia, velocity, period_s));
    println!("precession: exact {exact} rad/s, at 2 ms {coarse}, at 1 ms {fine}");
    let ratio = (coarse - exact) / (fine - exact);
    assert!((ratio - 4.0).abs() < 0.01, "not of second order: {ratio}");
    let extrapolated = fine + (fine - coarse) / 3.0;
    assert!((extrapolated / exact - 1.0).abs() < 1e-7, "{extrapolated} {exact}");
}

#[test]
fn a_sphere_turns_by_twice_the_arc_of_half_a_tick() {
    let rotor = Rotor::<f64>::new([2e-3; 3], 1e-3);
    let mut state = rotor.turning([1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 40.0]);
    for _ in 0..25 {
        rotor.coast(&mut state);
    }
    let [w, x, y, z] = state.orientation;
    assert!(x == 0.0 && y == 0.0 && (z.atan2(w) - 25.0 * 0.02_f64.atan()).abs() < 1e-15);
}

#[test]
fn fast_tops_keep_their_energy_too() {
    // A radian a tick is where it ends.
    for (speed, most) in [(100.0, 1e-13), (500.0, 1e-12), (900.0, 1e-9)] {
        let rotor = Rotor::<f64>::new(INERTIA, 1e-3);
        let mut state = rotor.turning([1.0, 0.0, 0.0, 0.0], [0.3 * speed, 0.9 * speed, 0.3 * speed]);
        let energy = rotor.energy_j(&state);
        let worst = (0..20_000).map(|_| {
            rotor.coast(&mut state);
            (rotor.energy_j(&state) / energy - 1.0).abs()
        });
        let worst = worst.fold(0.0, f64::max);
        println!("{speed} rad/s: energy {worst:.1e}");
        assert!(worst < most, "{speed} rad/s: {worst:e}");
    }
}

#[test]
fn a_port_gives_the_energy_that_it_takes() {
    let rotor = Rotor::<f64>::new(INERTIA, 1e-3);
    let mut state = rotor.turning([1.0, 0.2, -0.3, 0.1], [3.0, -8.0, 5.0]);
    // A push, and a damper that is stiff, not diagonal and not symmetric: it turns a part of the torque aside.
    let impedance = [[2.0, 0.5, 0.0], [-0.5, 1.0, 0.3], [0.0, -0.3, 4.0]];
    let port = TorquePort { torque: [0.3, -0.2, 0.1], impedance };
    for _ in 0..1000 {
        let (before, energy) = (state.momentum, rotor.energy_j(&state));
        let turned = rotor.step(&mut state, &port);
        let work: f64 = (0..3).map(|at| turned.torque[at] * turned.mean_velocity[at] * 1e-3).sum();
        let change = rotor.energy_j(&state) - energy;
        assert!((change - work).abs() < 1e-13 * energy.max(1.0), "{change} {work}");
        for axis in 0..3 {
            let said = port.torque[axis] - (0..3).map(|at| impedance[axis][at] * turned.mean_velocity[at]).sum::<f64>();
            assert!((turned.torque[axis] - said).abs() < 1e-12);
            assert!((state.momentum[axis] - before[axis] - 1e-3 * said).abs() < 1e-15);
        }
    }
    // At rest in the end: the torque is what the damper takes.
    assert!(norm(rotor.velocity(&state)) < 1.0);
}

#[test]
fn nothing_fails_on_what_is_no_number() {
    for bad in [f64::NAN, f64::INFINITY, 1e300, 0.0] {
        let rotor = Rotor::<f32>::new([bad, 1.0, 1.0], 1e-3);
        let mut state = rotor.turning([1.0, 0.0, 0.0, 0.0], [1.0, bad, 2.0]);
        let port = TorquePort { torque: [bad as f32; 3], impedance: [[bad as f32; 3]; 3] };
        for _ in 0..3 {
            rotor.step(&mut state, &port);
        }
    }
}
