//! Semi-implicit (symplectic) Euler: the new velocity moves the position.
//!
//! First order, but keeps the energy of an undamped oscillation bounded for k·T²/m < 4.

use super::{Before, Euler, Integrator};
use crate::model::Model;
use crate::num::{Motion, Scalar};
use crate::settings::{Refused, Settings};

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
