//! Backward difference: v\[n\] = (x\[n\] − x\[n−1\])/T_c.
//!
//! Units: m and m/s, or rad and rad/s. Exact for uniform motion; otherwise the velocity of half a tick ago, to first
//! order.
//!
//! Limits: one encoder count δ of rounding is δ/T_c of velocity noise (5 mm/s at the defaults), however slow the
//! motion.

use crate::num::{Motion, Scalar};
use crate::settings::{Refused, Settings};
use crate::{device::velocity::VelocityEstimator, model::Model};

/// The control period and one over it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference<S> {
    period_s: S,
    rate_hz: S,
}

impl<S: Scalar> Model<S> for Difference<S> {
    /// The last position, m or rad.
    type State = S;
    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        let period_s = settings.timing.control_period_s;
        Ok(Self { period_s: S::from_f64(period_s), rate_hz: S::from_f64(1.0 / period_s) })
    }
}

impl<S: Scalar> VelocityEstimator<S> for Difference<S> {
    fn start(&self, last: &mut S, at: Motion<S>) {
        *last = at.position - at.velocity * self.period_s;
    }
    #[inline]
    fn step(&self, last: &mut S, reading: Motion<S>) -> S {
        let velocity = (reading.position - *last) * self.rate_hz;
        *last = reading.position;
        velocity
    }
}
