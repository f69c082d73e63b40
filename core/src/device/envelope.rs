//! Limits of the mean force and power that a device may give to the hand, whatever is received and whichever law runs.
//!
//! Measured at the device's port while armed, over all axes together: the force on the hand, and the power P = F·v that
//! the device gives it (what the hand gives the device is [`super::watch`]'s). Both as leaky root-mean-squares
//! ([`super::leaky`]) over τ = `safety.rms_s`, which may not pass `safety.max_rms_force_n` or `safety.max_rms_power_w`.
//! A short peak counts by its square, and is forgotten with the time constant τ. A constant force F from rest is too
//! much after −τ·ln(1 − (limit/F)²).
//!
//! Not forgotten by a fault or by arming: while the motors are off both means fall as under no force.

use crate::num::{Motion, Scalar};
use crate::safety::Fault;
use crate::{device::leaky::Leaky, settings::Settings};

/// Limits of the root-mean-square force (N) and power (W) at the hand over `safety.rms_s`.
#[derive(Clone, Copy, Debug)]
pub struct Envelope<S> {
    leaky: Leaky<S>,
    /// Squares of the limits, N² and W².
    force: S,
    power: S,
}

configured!([S: Scalar] Envelope<S> { leaky, force, power });

/// Leaky means of the squares of force and power at the hand, N² and W².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load<S> {
    force: S,
    power: S,
}

impl<S: Scalar> Envelope<S> {
    /// From `safety.max_rms_force_n`, `safety.max_rms_power_w` and `safety.rms_s`.
    pub fn build(settings: &Settings) -> Self {
        let safety = &settings.safety;
        Self {
            leaky: Leaky::new(settings.timing.control_period_s, safety.rms_s),
            force: S::from_f64(safety.max_rms_force_n * safety.max_rms_force_n),
            power: S::from_f64(safety.max_rms_power_w * safety.max_rms_power_w),
        }
    }

    /// Advances the means by one tick with the motors off.
    #[inline]
    pub fn rest(&self, load: &mut Load<S>) {
        load.force = self.leaky.forget(load.force);
        load.power = self.leaky.forget(load.power);
    }

    /// Advances the means by one tick of forces (N) and power (W) given to the hand: the limit exceeded, if any.
    #[inline]
    pub fn exceeded<const N: usize>(&self, load: &mut Load<S>, forces: [S; N], power: S) -> Option<Fault> {
        let given = power.max(S::ZERO);
        load.force = self.leaky.after(load.force, total(forces.map(|force| force * force)));
        load.power = self.leaky.after(load.power, given * given);
        if load.force > self.force || load.power > self.power { Some(self.fault(load)) } else { None }
    }

    /// The fault of a load of which one is too much.
    #[cold]
    #[inline(never)]
    fn fault(&self, load: &Load<S>) -> Fault {
        if load.force > self.force { Fault::ForceTooLong } else { Fault::PowerTooLong }
    }
}

/// The power that forces (N) on axes in motion give the hand, W.
#[inline]
pub fn power<S: Scalar, const N: usize>(mut forces: [S; N], axes: [Motion<S>; N]) -> S {
    for (power, axis) in forces.iter_mut().zip(axes) {
        *power = *power * axis.velocity;
    }
    total(forces)
}

/// The sum of what every axis has, without a zero to begin with.
#[inline]
fn total<S: Scalar, const N: usize>(each: [S; N]) -> S {
    each.into_iter().reduce(|sum, one| sum + one).unwrap_or(S::ZERO)
}
