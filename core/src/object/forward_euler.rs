//! Forward Euler, the paper's integrator (§5): x ← x + T·ẋ, ẋ ← ẋ + (T/m)·(F − b·ẋ), both from the old ẋ.
//!
//! First order. Adds energy: an undamped spring k on the mass gains k·T²/m of its energy each tick.

use super::{Before, Euler, Integrator};
use crate::model::Model;
use crate::num::{Motion, Scalar};
use crate::settings::{Refused, Settings};

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
