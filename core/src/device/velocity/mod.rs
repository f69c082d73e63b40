//! Joint velocity: where it comes from when only positions are measured.
//!
//! | name | velocity | lag | noise |
//! |---|---|---|---|
//! | `measured` | the one in the reading | none | the sensor's |
//! | `difference` | (x\[n\] − x\[n−1\])/T_c | T_c/2 | one encoder count per tick |
//! | `filtered` | the same through a one-pole low pass | about 1/(2π·cutoff) more | below √(π·cutoff·T_c) of that |
//! | `adaptive` | slope of the longest line that fits to ± one count | half the window | one count per window |
//!
//! `measured` needs a device, or a simulator, that has a velocity: encoders have none, and it then reads zero.
//!
//! Units: m and m/s, or rad and rad/s. A non-finite reading gives a non-finite velocity, and so may the next one
//! (`filtered`: every one until [`VelocityEstimator::start`]); [`crate::safety`] catches it.

pub mod adaptive;
pub mod difference;

use crate::model::Model;
use crate::num::{Motion, Scalar};
use crate::settings::{Refused, Settings};

pub use crate::names::VelocityName;

/// Estimates a joint's velocity from its readings.
pub trait VelocityEstimator<S: Scalar>: Model<S> {
    /// Forgets the past: the joint has moved uniformly up to `at`, which is the reading that the next `step` takes.
    fn start(&self, state: &mut Self::State, at: Motion<S>);
    /// The velocity (m/s or rad/s) now, after the reading of this tick; called once per tick.
    fn step(&self, state: &mut Self::State, reading: Motion<S>) -> S;
}

/// The velocity that comes with the reading, m/s or rad/s, passed on unchanged, NaN included.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Measured;

configured!([] Measured {});

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

list! {
    /// Any one of the velocity estimators, with its state.
    AnyVelocity, named by VelocityName in axis.velocity {
        Measured(Measured),
        Difference(difference::Difference<S>),
        Filtered(difference::Filtered<S>),
        Adaptive(adaptive::Adaptive<S>),
    }
}

impl<S: Scalar> AnyVelocity<S> {
    /// Starts the estimator at this motion ([`VelocityEstimator::start`]).
    #[inline]
    pub fn start(&mut self, at: Motion<S>) {
        each!(self: Measured | Difference | Filtered | Adaptive, model, state => model.start(state, at));
    }

    /// Takes in one reading and gives the velocity, m/s or rad/s ([`VelocityEstimator::step`]).
    #[inline]
    pub fn step(&mut self, reading: Motion<S>) -> S {
        each!(self: Measured | Difference | Filtered | Adaptive, model, state => model.step(state, reading))
    }
}
