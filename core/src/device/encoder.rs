//! Raw encoder counts to joint position, across the wrap of a 16-bit timer, with a plausibility check.
//!
//! Design: the step since the last reading is taken modulo 2¹⁶ as a signed number, so the shorter way round is the one
//! that was moved; steps add up in 32 bits. A step longer than the fastest plausible motion is not believed.
//!
//! Units: m for a slide, rad for a joint that turns; which one, `kinematics.model` says.
//!
//! Invariants: a refused reading changes nothing, so that a reading after a glitch is measured against the last good
//! one; the first reading after a default state is position zero.
//!
//! Limits: the total is exact to ±2³¹ counts, and refused beyond; in `f32` the position rounds to 24 bits (past 2²⁴
//! counts, 84 m at the default resolution). Where the fastest plausible step exceeds 2¹⁵ − 1 counts the timer would wrap
//! unseen, and nothing could tell: [`check`] refuses such settings. Whoever reads counts asks it first.

use crate::settings::{Allowed, Refused, Settings};
use crate::{device::kinematics::Joints, num::Scalar};

pub use super::Counts;

/// Scale, direction and plausibility limit of every joint's encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoder<S> {
    counts_per_unit: S,
    resolution: S,
    max_step_counts: i32,
    reversed: bool,
}

/// What one encoder has seen so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EncoderState {
    /// Counts since the first reading, along the joint.
    pub total: i32,
    /// The last reading that was believed.
    pub last: Counts,
    /// A first reading has been taken; without it, the next one is taken as where the joint already is.
    pub primed: bool,
}

/// A plausible step may exceed `encoder.max_speed_m_per_s` by this factor, so that a motion that is faster than
/// `safety.max_speed_m_per_s`, where the two are equal, is called that before it is called a broken encoder…
const SPEED_MARGIN: f64 = 1.25;
/// …and by these counts, one for the rounding of each of the two readings.
const ROUNDING_COUNTS: f64 = 2.0;

/// Refuses an encoder.max_speed_m_per_s at which the counter could wrap between two readings: a motion that fast would be
/// taken for a slower one, the other way.
pub fn check(settings: &Settings) -> Result<(), Refused<'static>> {
    let Joints { counts_per_unit, most_per_m } = Joints::of(settings);
    let counts_per_speed = SPEED_MARGIN * most_per_m * settings.timing.control_period_s * counts_per_unit;
    let max = (f64::from(i16::MAX) - ROUNDING_COUNTS) / counts_per_speed;
    settings.within("encoder.max_speed_m_per_s", Allowed::Number { min: 0.0, max })
}

impl<S: Scalar> Encoder<S> {
    /// From `encoder`, `timing` and `kinematics`.
    pub fn build(settings: &Settings) -> Self {
        let Joints { counts_per_unit, most_per_m } = Joints::of(settings);
        let joint_speed = settings.encoder.max_speed_m_per_s * most_per_m;
        let max_step = SPEED_MARGIN * joint_speed * settings.timing.control_period_s * counts_per_unit;
        Self {
            counts_per_unit: S::from_f64(counts_per_unit),
            resolution: S::from_f64(1.0 / counts_per_unit),
            // A float-to-integer cast saturates, and takes NaN to 0.
            max_step_counts: ((max_step + ROUNDING_COUNTS) as i32).min(i32::from(i16::MAX)),
            reversed: settings.encoder.reversed,
        }
    }

    /// Joint position (m or rad) after a reading; none, and nothing changes, after an implausible one.
    #[inline]
    pub fn step(&self, state: &mut EncoderState, counts: Counts) -> Option<S> {
        if !state.primed {
            *state = EncoderState { total: state.total, last: counts, primed: true };
        }
        let raw = i32::from(counts.0.wrapping_sub(state.last.0).cast_signed());
        let step_counts = if self.reversed { -raw } else { raw };
        match state.total.checked_add(step_counts) {
            Some(total) if step_counts.abs() <= self.max_step_counts => {
                *state = EncoderState { total, last: counts, primed: true };
                Some(S::from_i32(total).ratio(self.counts_per_unit))
            }
            _ => None,
        }
    }

    /// One count, as joint position (m or rad).
    pub fn resolution(&self) -> S {
        self.resolution
    }

    /// Longest step of one tick that is believed, counts; at most 2¹⁵ − 1.
    pub fn max_step_counts(&self) -> i32 {
        self.max_step_counts
    }
}
