//! Backward difference, as it is or through a one-pole low pass.
//!
//! v\[n\] = (x\[n\] − x\[n−1\])/T_c is exact for uniform motion; otherwise the velocity of half a tick ago, to first order. One
//! encoder count δ of rounding is δ/T_c of velocity noise (5 mm/s at the defaults), however slow the motion.
//!
//! Filtered: v ← e^(−ω·T_c)·v + (1 − e^(−ω·T_c))·(x\[n\] − x\[n−1\])/T_c, with ω = 2π·`axis.velocity_cutoff_hz`: discretised exactly
//! for an input held over the tick, the same rule as the wave filter's (THEORY §2). Gain one at rest, stable for every cutoff, no
//! overshoot. Lags a ramp by T_c/2 + T_c/(e^(ω·T_c) − 1), about 1/ω. A non-finite reading stays in the filter until `start`.
//!
//! Units: m and m/s, or rad and rad/s.

use crate::num::{Motion, Scalar};
use crate::settings::{Allowed, Refused, Settings};
use crate::{device::velocity::VelocityEstimator, model::Model};

/// Velocity estimator that takes the backward difference of positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference<S> {
    period_s: S,
    rate_hz: S,
}

configured!([S: Scalar] Difference<S> { period_s, rate_hz });

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

/// Velocity estimator that takes the backward difference through a one-pole low-pass filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filtered<S> {
    difference: Difference<S>,
    gain: S,
}

configured!([S: Scalar] Filtered<S> { difference, gain });

impl<S: Scalar> Model<S> for Filtered<S> {
    /// The last position (m or rad) and the filtered velocity (m/s or rad/s).
    type State = (S, S);
    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        // From half the sample rate on there is nothing left to cut off.
        let max = 0.5 / settings.timing.control_period_s;
        settings.within("axis.velocity_cutoff_hz", Allowed::Number { min: 0.1, max })?;
        let angle = core::f64::consts::TAU * settings.axis.velocity_cutoff_hz * settings.timing.control_period_s;
        Ok(Self { difference: Difference::build(settings)?, gain: S::from_f64(-libm::expm1(-angle)) })
    }
}

impl<S: Scalar> VelocityEstimator<S> for Filtered<S> {
    fn start(&self, (last, velocity): &mut (S, S), at: Motion<S>) {
        self.difference.start(last, at);
        *velocity = at.velocity;
    }
    #[inline]
    fn step(&self, (last, velocity): &mut (S, S), reading: Motion<S>) -> S {
        let raw = self.difference.step(last, reading);
        *velocity = *velocity + self.gain * (raw - *velocity);
        *velocity
    }
}
