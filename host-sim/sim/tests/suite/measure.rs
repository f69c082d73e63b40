//! What simulates and measures, against closed forms: the plant's mass, damper and spring, and means.

use cohold_core::num::Motion;
use cohold_sim::measure::{LastHalf, Statistics};
use cohold_sim::plant::Linear;

/// Closed form of a mass with damping: x = (t − (m/b)(1 − e^(−bt/m)))·F/b.
#[test]
fn a_damped_mass_follows_its_closed_form() {
    for (mass, damping, period) in [(0.1, 1.0, 1e-3), (1e-4, 50.0, 0.01), (1000.0, 0.5, 1e-3), (0.3, 1e4, 0.1)] {
        let linear = Linear::new(mass, damping, 0.0, 0.0, period);
        let x: f64 = damping * period / mass;
        let velocity = -(-x).exp_m1() / damping;
        let [position_gain, velocity_gain] = linear.gain_now;
        let position = (period - mass / damping * -(-x).exp_m1()) / damping;
        assert!((velocity_gain / velocity - 1.0).abs() < 1e-13, "{mass} {damping}: {velocity_gain} {velocity}");
        // The closed form itself cancels for small x.
        assert!((position_gain / position - 1.0).abs() < 1e-13 + 1e-15 / (x * x), "{position_gain} {position}");
    }
}

/// Closed form of an undamped oscillator: it comes back after one period of 2π√(m/k).
#[test]
fn an_oscillator_returns_after_its_period() {
    let (mass, stiffness, ticks) = (0.2, 500.0, 1000);
    let period = core::f64::consts::TAU * f64::sqrt(mass / stiffness) / f64::from(ticks);
    let linear = Linear::new(mass, 0.0, stiffness, 0.3, period);
    let mut motion = Motion { position: 0.01, velocity: 0.2 };
    let start = motion;
    for _ in 0..ticks {
        motion = linear.advance(motion, 0.0, 0.0);
    }
    assert!((motion.position - start.position).abs() < 1e-13);
    assert!((motion.velocity - start.velocity).abs() < 1e-12);
}

/// Half a tick of the old force and half of the new one is two half ticks in sequence.
#[test]
fn a_late_force_is_two_shorter_steps() {
    let (late, half) = (Linear::new(0.1, 1.0, 80.0, 0.5, 1e-3), Linear::new(0.1, 1.0, 80.0, 0.0, 5e-4));
    let start = Motion { position: 0.01, velocity: -0.3 };
    let expected = half.advance(half.advance(start, 0.0, 2.0), 0.0, -5.0);
    let got = late.advance(start, 2.0, -5.0);
    assert!((got.position - expected.position).abs() < 1e-16);
    assert!((got.velocity - expected.velocity).abs() < 1e-14);
}

#[test]
fn only_the_last_half_counts() {
    let mut halves = LastHalf::new(4);
    assert!(halves.means().iter().all(|mean| mean.is_nan()));
    (0..4).for_each(|tick| halves.see(tick, [tick as f64, (tick * tick) as f64]));
    let [mean, mean_square] = halves.means();
    assert_eq!(Statistics::of_moments(mean, mean_square), Statistics { mean: 2.5, sd: 0.5 });
}
