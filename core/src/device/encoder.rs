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
//! Limits: the total is exact to ±2³¹ counts, and refused beyond; in `f32` the position rounds to 24 bits (past 2²⁴ counts, 84 m at the default
//! resolution). Where the fastest plausible step exceeds 2¹⁵ − 1 counts the timer would wrap unseen: [`check`], asked first, refuses such settings.

use crate::device::kinematics::{Joints, KinematicsName};
use crate::num::Scalar;
use crate::safety::{Fault, Patience};
use crate::settings::{Allowed, Refused, Settings};

pub use super::Counts;

/// Scale, direction and plausibility limit of every joint's encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoder<S> {
    counts_per_unit: S,
    resolution: S,
    max_step_counts: i32,
    /// 1, or −1 where it counts against the joint.
    along: i32,
    /// With an index: counts from one to the next, of a slide more than there are; and those that the joint is at where it is.
    revolution: Option<S>,
    index_at: i32,
}

configured!([S: Scalar] Encoder<S> { counts_per_unit, resolution, max_step_counts, along, revolution, index_at });

/// What the hardware saw of an encoder since the tick before, beside its count: edges and the index pulse.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Marks {
    /// One channel rose twice or more, and the other not at all.
    pub lone: bool,
    /// The counter's value at the index, if the index came.
    pub index: Option<Counts>,
}

impl Marks {
    /// Of an encoder that showed nothing.
    const NONE: Self = Self { lone: false, index: None };

    /// The marks of an encoder, from which of its channels A and B rose (`once`), and rose again after that (`again`).
    #[inline(always)]
    pub fn of(once: [bool; 2], again: [bool; 2], index: Option<Counts>) -> Self {
        Self { lone: again[0] & !once[1] | again[1] & !once[0], index }
    }
}

/// What the encoders of a device showed beside their counts.
#[derive(Clone, Copy, Debug)]
pub enum Shown<'a, const N: usize> {
    /// The hardware does not report it, or was not asked in this tick.
    Unknown,
    /// No marks.
    Nothing,
    /// These, of which any may show nothing.
    Marks(&'a [Marks; N]),
}

/// What one encoder has seen so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EncoderState {
    /// Counts since the first reading, along the joint.
    pub total: i32,
    /// The last reading that was believed.
    pub last: Counts,
    /// A reading has been taken; without one, the next defines where the joint already is.
    pub primed: bool,
    /// Position of the index as it was first seen, as counts of `total`.
    pub index: Option<i32>,
    /// Memory of ticks in which one channel rose without the other.
    pub lone: Patience,
}

/// A plausible step may exceed `encoder.max_speed_m_per_s` by this factor, so that a motion that is faster than
/// `safety.max_speed_m_per_s`, where the two are equal, is called that before it is called a broken encoder…
const SPEED_MARGIN: f64 = 1.25;
/// …and by these counts, one for the rounding of each of the two readings.
const ROUNDING_COUNTS: f64 = 2.0;
/// Ticks with edges on one channel only that make a fault: a device that vibrates on an edge gives no two rising edges
/// in a tick, a cut wire does from 8 counts a tick on.
pub const LONE_TICKS: u32 = 4;
/// Tolerance of the index position, counts: the pulse is at most one period wide, and may be met from either side.
pub const INDEX_COUNTS: i32 = 4;

/// Refuses an encoder.max_speed_m_per_s at which the counter could wrap between two readings: it would be taken for a slower one, the other way.
///
/// # Errors
/// The key and the largest speed (m/s) that the counter can follow.
pub fn check(settings: &Settings) -> Result<(), Refused<'static>> {
    check_step(settings, i16::MAX as u32)
}

/// The same of a counter, or an angle, whose readings may be no further apart than that.
///
/// # Errors
/// The key and the largest speed (m/s) that can be followed so.
pub fn check_step(settings: &Settings, most_counts: u32) -> Result<(), Refused<'static>> {
    let Joints { counts_per_unit, most_per_m, .. } = Joints::of(settings);
    let counts_per_speed = SPEED_MARGIN * most_per_m * settings.timing.control_period_s * counts_per_unit;
    let max = (f64::from(most_counts) - ROUNDING_COUNTS) / counts_per_speed;
    settings.within("encoder.max_speed_m_per_s", Allowed::Number { min: 0.0, max })
}

impl<S: Scalar> Encoder<S> {
    /// From `encoder`, `timing` and `kinematics`.
    pub fn build(settings: &Settings) -> Self {
        let Joints { counts_per_unit, most_per_m, .. } = Joints::of(settings);
        let joint_speed = settings.encoder.max_speed_m_per_s * most_per_m;
        let revolution = match settings.kinematics.model {
            KinematicsName::Direct => f64::from(1 << 30),
            _ => settings.encoder.counts_per_rev,
        };
        let max_step = SPEED_MARGIN * joint_speed * settings.timing.control_period_s * counts_per_unit;
        Self {
            counts_per_unit: S::from_f64(counts_per_unit),
            resolution: S::from_f64(1.0 / counts_per_unit),
            // A float-to-integer cast saturates, and takes NaN to 0.
            max_step_counts: ((max_step + ROUNDING_COUNTS) as i32).min(i32::from(i16::MAX)),
            along: if settings.encoder.reversed { -1 } else { 1 },
            revolution: settings.encoder.index.then(|| S::from_f64(revolution)),
            index_at: (settings.encoder.index_at_m_or_rad * counts_per_unit) as i32,
        }
    }

    /// Joint position (m or rad) after a reading; none, and nothing changes, after an implausible one.
    #[inline]
    pub fn step(&self, state: &mut EncoderState, counts: Counts) -> Option<S> {
        if !state.primed {
            (state.last, state.primed) = (counts, true);
        }
        let raw = i32::from(counts.0.wrapping_sub(state.last.0).cast_signed());
        match state.total.checked_add(raw * self.along) {
            Some(total) if raw.abs() <= self.max_step_counts => {
                (state.total, state.last) = (total, counts);
                Some(S::from_i32(total).over(self.counts_per_unit))
            }
            _ => None,
        }
    }

    /// Joint position (m or rad) at the last reading.
    pub fn position(&self, state: &EncoderState) -> S {
        S::from_i32(state.total).ratio(self.counts_per_unit)
    }

    /// The same, if the index was met where it should be; none while only the place at the start is known.
    #[inline(always)]
    pub fn absolute(&self, state: &EncoderState) -> Option<S> {
        let near = |index: i32| index.abs_diff(self.index_at) <= INDEX_COUNTS.unsigned_abs();
        state.index.is_some_and(near).then(|| self.position(state))
    }

    /// The marks for [`Encoder::heed`], if it is needed for any of the encoders; in most ticks it would change nothing.
    #[inline(always)]
    pub fn heeds<'a, const N: usize>(states: [&EncoderState; N], shown: Shown<'a, N>) -> Option<&'a [Marks; N]> {
        let calm = Patience::default();
        let is_calm = || states.iter().fold(true, |calm_all, state| calm_all & (state.lone == calm));
        match shown {
            Shown::Unknown => None,
            Shown::Nothing => {
                if is_calm() {
                    None
                } else {
                    Some(const { &[Marks::NONE; N] })
                }
            }
            Shown::Marks(marks) => {
                let none = marks.iter().fold(true, |none, marks| none & !marks.lone & marks.index.is_none());
                if none && is_calm() { None } else { Some(marks) }
            }
        }
    }

    /// Processes the marks that came with the reading just taken. The first index sets the joint's position there to
    /// `encoder.index_at_m_or_rad`, if it `may_move`; true if that was done.
    ///
    /// # Errors
    /// [`Fault::EncoderWire`] after [`LONE_TICKS`] ticks with two edges of one channel and none of the other, counted up and down;
    /// [`Fault::LostCounts`] if the index is not a whole number of revolutions (of a slide: none) from where it was first seen, to
    /// [`INDEX_COUNTS`].
    pub fn heed(&self, state: &mut EncoderState, marks: &Marks, may_move: bool) -> Result<bool, Fault> {
        if state.lone.spent(marks.lone, LONE_TICKS) {
            return Err(Fault::EncoderWire);
        }
        let (Some(index), Some(revolution)) = (marks.index, self.revolution) else { return Ok(false) };
        let back = i32::from(state.last.0.wrapping_sub(index.0).cast_signed());
        let at = state.total.wrapping_sub(back * self.along);
        let Some(first) = state.index else {
            state.index = Some(if may_move { self.index_at } else { at });
            if may_move {
                state.total = state.total.wrapping_sub(at).wrapping_add(self.index_at);
            }
            return Ok(may_move);
        };
        let off = S::from_i32(at.wrapping_sub(first));
        // Of a slide the quotient is 0.
        let turns = S::from_i32(off.ratio(revolution).round_to_i32());
        if (off - turns * revolution).abs() <= S::from_i32(INDEX_COUNTS) { Ok(false) } else { Err(Fault::LostCounts) }
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
