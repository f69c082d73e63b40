//! First-order adaptive windowing, end-fit: slope over the longest window that a line fits to ± one encoder count.
//!
//! With Δᵢ = x\[n\] − x\[n−i\], the velocity is Δₖ/(k·T_c) for the largest k ≤ `axis.velocity_window_ticks` such that
//! the line through the newest and the k-th last position passes within ±δ of every position between: slow motion is
//! averaged over a long window, fast motion changes are followed at once. k = 1 always fits, and is the backward
//! difference.
//!
//! Design: a line of slope s (per tick) through the newest position passes within ±δ of the i-th last exactly if (Δᵢ −
//! δ)/i ≤ s ≤ (Δᵢ + δ)/i. So one pass that keeps the intersection of these intervals finds k in O(window), with 1/i and δ/i
//! computed in `build`. The intersection only shrinks: once it is empty no longer window can fit, so a band of less than
//! nothing ends the window, and every tick takes the same time.
//!
//! Units: m and m/s, or rad and rad/s. Error of uniform motion ≤ δ/(k·T_c).
//!
//! Limits: under an acceleration a the window opens until the motion bends by δ, so the velocity lags by up to
//! √(2·a·δ). That beats the difference, whose noise is about 0.4·δ/T_c, where a < 0.08·δ/T_c²: 0.4 m/s² at the
//! defaults. Made for coarse encoders and gentle hands, not for impacts. δ is taken [`SLACK`] wider, so that a position
//! dithering between two counts, which is at ±δ exactly, stands still however numbers round. Positions must be
//! quantised no coarser than δ.
//!
//! Reference: Janabi-Sharifi, Hayward & Chen, "Discrete-time adaptive windowing for velocity estimation", IEEE Trans.
//! Control Systems Technology 8(6), 2000, end-fit FOAW; their procedure stops at the first k that does not fit, this is
//! their definition: the largest that does.

use crate::num::{Motion, Scalar};
use crate::settings::{Refused, Settings};
use crate::{device::kinematics::Joints, device::velocity::VelocityEstimator, model::Model};

/// Longest window of the slope, ticks.
pub const MAX_WINDOW: usize = 16;
/// Relative widening of the band of one count. No count lies between 1 and 1 + 1/16 counts off a line through two
/// others at most 16 apart, so the middle of that gap is as far from any rounding as can be.
pub const SLACK: f64 = 1.0 / 32.0;

/// Velocity estimator with an adaptive window (FOAW).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptive<S> {
    rate_hz: S,
    period_s: S,
    /// δ.
    band: S,
    /// 1/i and δ/i for i = 2…window; beyond the window, a band that no slope lies in.
    longer: [(S, S); MAX_WINDOW - 1],
}

configured!([S: Scalar] Adaptive<S> { rate_hz, period_s, band, longer });

impl<S: Scalar> Model<S> for Adaptive<S> {
    /// The last positions (m or rad), newest first.
    type State = [S; MAX_WINDOW];
    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        let band = (1.0 + SLACK) / Joints::of(settings).counts_per_unit;
        let mut ago = 1;
        Ok(Self {
            rate_hz: S::from_f64(1.0 / settings.timing.control_period_s),
            period_s: S::from_f64(settings.timing.control_period_s),
            band: S::from_f64(band),
            longer: [(); MAX_WINDOW - 1].map(|()| {
                ago += 1;
                let reciprocal = 1.0 / f64::from(ago);
                let fits = ago <= settings.axis.velocity_window_ticks;
                (S::from_f64(reciprocal), if fits { S::from_f64(band * reciprocal) } else { -S::ONE })
            }),
        })
    }
}

impl<S: Scalar> VelocityEstimator<S> for Adaptive<S> {
    fn start(&self, history: &mut [S; MAX_WINDOW], at: Motion<S>) {
        let step = at.velocity * self.period_s;
        let mut position = at.position;
        for slot in history.iter_mut() {
            position = position - step;
            *slot = position;
        }
    }

    #[inline]
    fn step(&self, history: &mut [S; MAX_WINDOW], reading: Motion<S>) -> S {
        self.slope(history, reading.position) * self.rate_hz
    }
}

impl<S: Scalar> Adaptive<S> {
    /// Slope of the longest line that fits up to the newest position (m or rad), in m or rad a tick.
    // What every other estimator pays for if this one is inlined: its registers.
    #[inline(never)]
    fn slope(&self, history: &mut [S; MAX_WINDOW], newest: S) -> S {
        let [last, older @ ..] = history;
        let mut carried = core::mem::replace(last, newest);
        let mut slope = newest - carried;
        let (mut lowest, mut highest) = (slope - self.band, slope + self.band);
        for (slot, &(reciprocal, band)) in older.iter_mut().zip(&self.longer) {
            let past = core::mem::replace(slot, carried);
            carried = past;
            let candidate = (newest - past) * reciprocal;
            // In this order a position that is no number is passed over.
            lowest = (candidate - band).max(lowest);
            highest = (candidate + band).min(highest);
            slope = candidate.if_between(lowest, highest, slope);
        }
        slope
    }
}
