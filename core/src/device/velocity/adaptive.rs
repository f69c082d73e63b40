//! First-order adaptive windowing, end-fit: slope over the longest window that a line fits to ± one encoder count.
//!
//! With Δᵢ = x\[n\] − x\[n−i\], the velocity is Δₖ/(k·T_c) for the largest k ≤ `axis.velocity_window_ticks` such that
//! the line through the newest and the k-th last position passes within ±δ of every position between: slow motion is
//! averaged over a long window, fast motion changes are followed at once. k = 1 always fits, and is the backward
//! difference.
//!
//! Design: a line of slope s (per tick) through the newest position passes within ±δ of the i-th last exactly if (Δᵢ −
//! δ)/i ≤ s ≤ (Δᵢ + δ)/i. So one pass that keeps the intersection of these intervals finds k in O(window), with the
//! reciprocals 1/i computed in `build`. The intersection only shrinks: once it is empty no longer window can fit.
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

/// Longest window, ticks.
pub const MAX_WINDOW: usize = 16;
/// How much wider than one count the band is taken. No count lies between 1 and 1 + 1/16 counts off a line through two
/// others at most 16 apart, so the middle of that gap is as far from any rounding as can be.
pub const SLACK: f64 = 1.0 / 32.0;

/// Band, reciprocals and rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptive<S> {
    band: S,
    rate_hz: S,
    period_s: S,
    /// 1/i for i = 1…window.
    reciprocals: [S; MAX_WINDOW],
    window: usize,
}

impl<S: Scalar> Model<S> for Adaptive<S> {
    /// The last positions (m or rad), newest first.
    type State = [S; MAX_WINDOW];
    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        let mut ticks = 0.0;
        Ok(Self {
            band: S::from_f64((1.0 + SLACK) / Joints::of(settings).counts_per_unit),
            rate_hz: S::from_f64(1.0 / settings.timing.control_period_s),
            period_s: S::from_f64(settings.timing.control_period_s),
            reciprocals: [(); MAX_WINDOW].map(|()| {
                ticks += 1.0;
                S::from_f64(1.0 / ticks)
            }),
            window: (settings.axis.velocity_window_ticks as usize).clamp(1, MAX_WINDOW),
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
        let newest = reading.position;
        let [last, ..] = *history;
        let mut slope = newest - last;
        let (mut lowest, mut highest) = (slope - self.band, slope + self.band);
        for (&past, &reciprocal) in history.iter().zip(&self.reciprocals).take(self.window).skip(1) {
            if lowest > highest {
                break;
            }
            let moved = newest - past;
            let candidate = moved * reciprocal;
            if candidate >= lowest && candidate <= highest {
                slope = candidate;
            }
            lowest = lowest.max((moved - self.band) * reciprocal);
            highest = highest.min((moved + self.band) * reciprocal);
        }
        let mut carried = newest;
        for slot in history.iter_mut() {
            core::mem::swap(slot, &mut carried);
        }
        slope * self.rate_hz
    }
}
