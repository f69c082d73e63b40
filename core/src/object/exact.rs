//! Exact zero-order hold: the matrix exponential of m·ẍ + b·ẋ = F for a force that is constant in two pieces.
//!
//! With a delay of τ ticks, the old force acts on \[0, τ·T\] and the new one on \[τ·T, T\]. The coefficients are worked out
//! once in f64; the tick is seven products. Range: any m > 0, b ≥ 0; b·T/m below 1 goes through a series, so that b → 0
//! loses no digits.

use super::{Before, Integrator};
use crate::model::Model;
use crate::num::{Motion, Scalar};
use crate::settings::{Refused, Settings};

/// A mass with damping under piecewise constant force.
#[derive(Clone, Copy, Debug)]
pub struct Exact<S> {
    /// e^(−b·T/m).
    velocity_kept: S,
    /// ∫ e^(−b·t/m) dt over the tick, s.
    velocity_to_position: S,
    /// What the old and the new force add to the velocity, 1/(kg/s).
    velocity_gain: [S; 2],
    /// What the old and the new force add to the position, m/N.
    position_gain: [S; 2],
}

configured!([S: Scalar] Exact<S> { velocity_kept, velocity_to_position, velocity_gain, position_gain });

/// Response to a unit force held for `time` from rest: (velocity, position) in m/s and m per newton.
fn response(mass_kg: f64, damping: f64, time: f64) -> (f64, f64) {
    let x = damping * time / mass_kg;
    // (1 − e^(−x))/x and (x − 1 + e^(−x))/x², without cancellation: relative error < 4e-16.
    let (first, second) = if x < 1.0 {
        // ½ − x/3! + x²/4! − …; the first term left out is below 3e-17 of the sum.
        let second = 0.5 * (3..=18).rev().fold(1.0, |sum, n| 1.0 - x / f64::from(n) * sum);
        (1.0 - x * second, second)
    } else {
        let first = -libm::expm1(-x) / x;
        (first, (1.0 - first) / x)
    };
    (time / mass_kg * first, time * time / mass_kg * second)
}

impl<S: Scalar> Model<S> for Exact<S> {
    type State = Before<S>;
    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        let (object, period_s) = (&settings.object, settings.timing.control_period_s);
        let (mass_kg, damping) = (object.mass_kg, object.damping_n_s_per_m);
        let whole = response(mass_kg, damping, period_s);
        let fresh = response(mass_kg, damping, (1.0 - object.force_delay_ticks) * period_s);
        Ok(Self {
            velocity_kept: S::from_f64(libm::exp(-damping * period_s / mass_kg)),
            velocity_to_position: S::from_f64(mass_kg * whole.0),
            velocity_gain: [S::from_f64(whole.0 - fresh.0), S::from_f64(fresh.0)],
            position_gain: [S::from_f64(whole.1 - fresh.1), S::from_f64(fresh.1)],
        })
    }
}

impl<S: Scalar> Integrator<S> for Exact<S> {
    #[inline]
    fn step(&self, before: &mut Before<S>, motion: Motion<S>, force: S) -> Motion<S> {
        let ([x_before, x_now], [v_before, v_now]) = (self.position_gain, self.velocity_gain);
        let step = self.velocity_to_position * motion.velocity + x_before * before.force + x_now * force;
        let velocity = self.velocity_kept * motion.velocity + v_before * before.force + v_now * force;
        before.force = force;
        Motion::new(before.carry.add(motion.position, step), velocity)
    }
}
