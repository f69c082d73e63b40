//! The velocity that comes with the reading.
//!
//! For devices that measure velocity and for simulated ones. m/s or rad/s, passed on unchanged, NaN included.

use crate::device::velocity::VelocityEstimator;
use crate::model::Model;
use crate::num::{Motion, Scalar};
use crate::settings::{Refused, Settings};

/// Passes the reading's velocity on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Measured;

impl<S: Scalar> Model<S> for Measured {
    type State = ();
    fn build(_: &Settings) -> Result<Self, Refused<'static>> {
        Ok(Self)
    }
}

impl<S: Scalar> VelocityEstimator<S> for Measured {
    fn start(&self, (): &mut (), _: Motion<S>) {}
    #[inline]
    fn step(&self, (): &mut (), reading: Motion<S>) -> S {
        reading.velocity
    }
}
