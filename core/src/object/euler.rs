//! The two Euler forms of x ← x + T·ẋ, ẋ ← ẋ + (T/m)·(F − b·ẋ), both of first order.
//!
//! **Forward**, the paper's integrator (§5): both from the old ẋ. Adds energy: an undamped spring k on the mass gains k·T²/m of
//! its energy each tick. **Semi-implicit** (symplectic): the new ẋ moves the position. Keeps the energy of an undamped
//! oscillation bounded for k·T²/m < 4.

use super::{Before, Integrator};
use crate::model::Model;
use crate::num::{Motion, Scalar};
use crate::settings::{Refused, Settings};

/// What both Euler forms share: the gain from force to velocity and the delayed force.
#[derive(Clone, Copy, Debug)]
struct Euler<S> {
    period: S,
    /// T_c/m_O.
    gain: S,
    /// b_O.
    damping: S,
    /// τ.
    late: S,
    /// 1 − τ.
    prompt: S,
}

impl<S: Scalar> Euler<S> {
    fn build(settings: &Settings) -> Self {
        let (period, object) = (settings.timing.control_period_s, &settings.object);
        Self {
            period: S::from_f64(period),
            gain: S::from_f64(period / object.mass_kg),
            damping: S::from_f64(object.damping_n_s_per_m),
            late: S::from_f64(object.force_delay_ticks),
            prompt: S::from_f64(1.0 - object.force_delay_ticks),
        }
    }

    /// ẋ + (T_c/m)·(F − b·ẋ) with F = τ·F\[n−1\] + (1 − τ)·F\[n\].
    #[inline]
    fn velocity(&self, before: &mut Before<S>, velocity: S, force: S) -> S {
        let acting = self.late * before.force + self.prompt * force;
        before.force = force;
        velocity + self.gain * (acting - self.damping * velocity)
    }
}

/// Old velocity moves the position.
#[derive(Clone, Copy, Debug)]
pub struct ForwardEuler<S>(Euler<S>);

impl<S: Scalar> Model<S> for ForwardEuler<S> {
    type State = Before<S>;
    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        Ok(Self(Euler::build(settings)))
    }
}

impl<S: Scalar> Integrator<S> for ForwardEuler<S> {
    #[inline]
    fn step(&self, before: &mut Before<S>, motion: Motion<S>, force: S) -> Motion<S> {
        Motion {
            position: before.carry.add(motion.position, self.0.period * motion.velocity),
            velocity: self.0.velocity(before, motion.velocity, force),
        }
    }
}

/// New velocity moves the position.
#[derive(Clone, Copy, Debug)]
pub struct SemiImplicit<S>(Euler<S>);

impl<S: Scalar> Model<S> for SemiImplicit<S> {
    type State = Before<S>;
    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        Ok(Self(Euler::build(settings)))
    }
}

impl<S: Scalar> Integrator<S> for SemiImplicit<S> {
    #[inline]
    fn step(&self, before: &mut Before<S>, motion: Motion<S>, force: S) -> Motion<S> {
        let velocity = self.0.velocity(before, motion.velocity, force);
        Motion { position: before.carry.add(motion.position, self.0.period * velocity), velocity }
    }
}
