//! How warm a motor's winding is, from the current that flowed through it: I²t.
//!
//! One thermal mass: the mean square of the current over τ = `motor.thermal_s`, m ← m + (i² − m)·T_c/τ, may not pass the square of
//! `motor.continuous_a`. A constant current i from cold is too much after −τ·ln(1 − (continuous/i)²), one that the motor bears for
//! ever never.
//!
//! Units: A, A². Limits: the surroundings are as warm as where `continuous_a` was measured; a restart begins cold, so who restarts
//! waits; the copper's own, faster time is within τ.

use crate::{num::Scalar, settings::Settings};

/// The limit of one motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermal<S> {
    /// T_c/τ.
    share: S,
    /// A².
    most: S,
}

/// Mean square of one motor's current, A².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Heat<S>(S);

impl<S: Scalar> Thermal<S> {
    /// From `motor.continuous_a` and `motor.thermal_s`.
    pub fn build(settings: &Settings) -> Self {
        let motor = &settings.motor;
        Self {
            share: S::from_f64((settings.timing.control_period_s / motor.thermal_s).min(1.0)),
            most: S::from_f64(motor.continuous_a * motor.continuous_a),
        }
    }

    /// One tick of a current, A: whether the winding is warmer than it bears.
    #[inline]
    pub fn is_too_warm(&self, Heat(heat): &mut Heat<S>, current_a: S) -> bool {
        *heat = *heat + (current_a * current_a - *heat) * self.share;
        *heat > self.most
    }
}
