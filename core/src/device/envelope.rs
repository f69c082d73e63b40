//! Limits of the mean force and power that a device may give to the hand, whatever is received and whichever law runs.
//!
//! Measured at the device's port while armed, over all axes together: the force on the hand, and the power P = F·v that
//! the device gives it (what the hand gives the device is [`super::watch`]'s). Both as leaky root-mean-squares
//! ([`super::leaky`]) over τ = `safety.rms_s`, which may not pass `safety.max_rms_force_n` or `safety.max_rms_power_w`.
//! A short peak counts by its square, and is forgotten with the time constant τ. A constant force F from rest is too
//! much after −τ·ln(1 − (limit/F)²).
//!
//! **They limit.** From [`NEAR`] of a limit's square on, the largest force of every axis falls, in proportion to what is left to
//! the limit, from `safety.max_force_n` to what may last: `max_rms_force_n` shared among the axes, and for power that divided by how fast
//! they all move. So a mean comes near its limit and stays below, however long a hand presses, and the object receives as little as the
//! hand ([`crate::contact::grip`]). Only where a force outruns that, for τ is a few ticks, does the peer fault, at [`TOO_MUCH`] of the square.
//!
//! Not forgotten by a fault or by arming: while the motors are off both means fall as under no force.

use crate::num::{Motion, Scalar};
use crate::safety::Fault;
use crate::{device::leaky::Leaky, settings::Settings};

/// Share of a limit's square from which on the largest force falls.
pub const NEAR: f64 = 0.5;

/// Share of a limit's square at which the peer faults: 5 % above the limit itself.
pub const TOO_MUCH: f64 = 1.1025;

/// Limits of the root-mean-square force (N) and power (W) at the hand over `safety.rms_s`.
#[derive(Clone, Copy, Debug)]
pub struct Envelope<S> {
    leaky: Leaky<S>,
    /// What may last along each axis, N, and in all, W.
    force: S,
    power: S,
    /// One over the squares of the limits, 1/N² and 1/W².
    per_force: S,
    per_power: S,
}

configured!([S: Scalar] Envelope<S> { leaky, force, power, per_force, per_power });

/// Leaky means of the squares of force and power at the hand, as shares of their limits' squares.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load<S> {
    force: S,
    power: S,
}

impl<S: Scalar> Envelope<S> {
    /// From `safety.max_rms_force_n`, `safety.max_rms_power_w` and `safety.rms_s`.
    pub fn build(settings: &Settings) -> Self {
        let (force, power) = (settings.safety.max_rms_force_n, settings.safety.max_rms_power_w);
        Self {
            leaky: Leaky::new(settings.timing.control_period_s, settings.safety.rms_s),
            force: S::from_f64(force / libm::sqrt(f64::from(settings.axis.count))),
            power: S::from_f64(power),
            per_force: S::from_f64(1.0 / (force * force)),
            per_power: S::from_f64(1.0 / (power * power)),
        }
    }

    /// Advances the means by one tick with the motors off.
    #[inline]
    pub fn rest(&self, load: &mut Load<S>) {
        load.force = self.leaky.forget(load.force);
        load.power = self.leaky.forget(load.power);
    }

    /// Advances the means by one tick of forces (N) and power (W) given to the hand: whether one of them is near its limit.
    #[inline]
    pub fn nears<const N: usize>(&self, load: &mut Load<S>, forces: [S; N], power: S) -> bool {
        let given = power.max(S::ZERO);
        load.force = self.leaky.after(load.force, total(forces.map(|force| force * force)) * self.per_force);
        load.power = self.leaky.after(load.power, given * given * self.per_power);
        load.force.max(load.power) > S::from_f64(NEAR)
    }

    /// The largest force (N) of every axis after this load, of `full` (N) at most, while the axes move like this.
    #[inline(always)]
    pub fn most<const N: usize>(&self, load: &Load<S>, full: S, axes: [Motion<S>; N]) -> S {
        let speed = total(axes.map(|axis| axis.velocity.abs()));
        // A micrometre a second gives as little power as rest.
        let lasting = self.power.ratio(speed.max(S::from_f64(1e-6)));
        full.min(full * left(load.force) + self.force).min(full * left(load.power) + lasting)
    }
}

impl<S: Scalar> Load<S> {
    /// The fault of what is too much.
    #[cold]
    #[inline(never)]
    pub fn fault(&self) -> Option<Fault> {
        let too_much = S::from_f64(TOO_MUCH);
        let which = || if self.force > too_much { Fault::ForceTooLong } else { Fault::PowerTooLong };
        (self.force.max(self.power) > too_much).then(which)
    }
}

/// What is left of the largest force where a mean is this share of its limit: all up to [`NEAR`], nothing from 1 on.
#[inline(always)]
pub fn left<S: Scalar>(mean: S) -> S {
    ((S::ONE - mean) * S::from_f64(1.0 / (1.0 - NEAR))).max(S::ZERO).min(S::ONE)
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
