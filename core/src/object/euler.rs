//! The two Euler forms of x ← x + T·ẋ, ẋ ← ẋ + (T/m)·(F − b·ẋ), both of first order.
//!
//! **Forward**, the paper's integrator (§5): both from the old ẋ. Adds energy: an undamped spring k on the mass gains k·T²/m of
//! its energy each tick. **Semi-implicit** (symplectic): the new ẋ moves the position. Keeps the energy of an undamped
//! oscillation bounded for k·T²/m < 4.

use super::{Before, Integrator};
use crate::model::Model;
use crate::num::{Motion, Scalar};
use crate::settings::{Refused, Settings};

/// Forward (`NEW` is false) or semi-implicit Euler (`NEW` is true: the new velocity moves the position).
#[derive(Clone, Copy, Debug)]
pub struct Euler<S, const NEW: bool> {
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

configured!([S: Scalar, const NEW: bool] Euler<S, NEW> { period, gain, damping, late, prompt });

/// Forward Euler: the old velocity moves the position.
pub type ForwardEuler<S> = Euler<S, false>;

/// Semi-implicit Euler: the new velocity moves the position.
pub type SemiImplicit<S> = Euler<S, true>;

impl<S: Scalar, const NEW: bool> Model<S> for Euler<S, NEW> {
    type State = Before<S>;
    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        let (period, object) = (settings.timing.control_period_s, &settings.object);
        Ok(Self {
            period: S::from_f64(period),
            gain: S::from_f64(period / object.mass_kg),
            damping: S::from_f64(object.damping_n_s_per_m),
            late: S::from_f64(object.force_delay_ticks),
            prompt: S::from_f64(1.0 - object.force_delay_ticks),
        })
    }
}

impl<S: Scalar, const NEW: bool> Integrator<S> for Euler<S, NEW> {
    #[inline]
    fn step(&self, before: &mut Before<S>, motion: Motion<S>, force: S) -> Motion<S> {
        let acting = self.late * before.force + self.prompt * force;
        before.force = force;
        let velocity = motion.velocity + self.gain * (acting - self.damping * motion.velocity);
        let moving = if NEW { velocity } else { motion.velocity };
        Motion::new(before.carry.add(motion.position, self.period * moving), velocity)
    }
}
