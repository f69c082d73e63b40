//! A leaky mean: m ← m·(1 − T/τ) + x·T/τ, once every T.
//!
//! A constant x from m = 0 on passes a limit after −τ·ln(1 − limit/x); exactly, with the first n for which
//! 1 − (1 − T/τ)ⁿ > limit/x. One that is below the limit never does. A mean of squares is what warms a winding and tires a hand.
//!
//! Limits: in `f32` what comes in is lost where (x − m)·T/τ is below half a rounding of m: T/τ no smaller than 10⁻⁴ is fine.

use crate::num::Scalar;

/// A leaky mean (first-order low-pass filter), with the weight of a new value in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaky<S> {
    /// T/τ, and what is left of 1.
    share: S,
    keep: S,
}

configured!([S: Scalar] Leaky<S> { share, keep });

impl<S: Scalar> Leaky<S> {
    /// A leaky mean of one value every `period_s` (s) with the time constant `time_s` (s), or `period_s` if that is longer.
    pub fn new(period_s: f64, time_s: f64) -> Self {
        let share = (period_s / time_s).min(1.0);
        Self { share: S::from_f64(share), keep: S::from_f64(1.0 - share) }
    }

    /// The mean after a value.
    #[inline(always)]
    pub fn after(&self, mean: S, value: S) -> S {
        mean * self.keep + value * self.share
    }

    /// The mean after a value of zero.
    #[inline(always)]
    pub fn forget(&self, mean: S) -> S {
        mean * self.keep
    }
}
