//! The wave's filter, core's and two that are not in core, behind one trait.
//!
//! Their formulas and what they are compared with: [the filters](../../filters/index.html). Unit: √W in and out.

use cohold_core::law::decimate::{Decimator, OnePole};
use cohold_core::num::Scalar;
use cohold_core::settings::Settings;

/// A low-pass filter that can be compared.
pub trait Filter<S: Scalar> {
    /// Short name of the filter, for tables.
    const NAME: &'static str;
    /// Takes its coefficients from the cutoff and the control period.
    fn build(settings: &Settings) -> Self;
    /// One sample in, what would be sent out.
    fn push(&mut self, wave: S) -> S;
}

/// Core's: exact for a held input.
#[derive(Clone, Copy, Debug)]
pub struct Exact<S>(OnePole<S>, S);

impl<S: Scalar> Filter<S> for Exact<S> {
    const NAME: &'static str = "exact";
    fn build(settings: &Settings) -> Self {
        Self(OnePole::build(settings), S::ZERO)
    }
    #[inline]
    fn push(&mut self, wave: S) -> S {
        self.0.push(&mut self.1, wave);
        self.1
    }
}

/// Cutoff angle Ω_c·T_c, rad per tick.
pub fn angle(settings: &Settings) -> f64 {
    core::f64::consts::TAU * settings.coordination.cutoff_hz * settings.timing.control_period_s
}

/// The textbook's quickest; unstable from Ω_c·T_c = 2 on.
#[derive(Clone, Copy, Debug)]
pub struct ForwardEuler<S> {
    take: S,
    level: S,
}

impl<S: Scalar> Filter<S> for ForwardEuler<S> {
    const NAME: &'static str = "forward-euler";
    fn build(settings: &Settings) -> Self {
        Self { take: S::from_f64(angle(settings)), level: S::ZERO }
    }
    #[inline]
    fn push(&mut self, wave: S) -> S {
        self.level = self.level + self.take * (wave - self.level);
        self.level
    }
}

/// Tustin's trapezoid, without prewarping.
#[derive(Clone, Copy, Debug)]
pub struct Bilinear<S> {
    keep: S,
    take: S,
    level: S,
    last: S,
}

impl<S: Scalar> Filter<S> for Bilinear<S> {
    const NAME: &'static str = "bilinear";
    fn build(settings: &Settings) -> Self {
        let angle = angle(settings);
        let (keep, take) = ((2.0 - angle) / (2.0 + angle), angle / (2.0 + angle));
        Self { keep: S::from_f64(keep), take: S::from_f64(take), level: S::ZERO, last: S::ZERO }
    }
    #[inline]
    fn push(&mut self, wave: S) -> S {
        self.level = self.keep * self.level + self.take * (wave + self.last);
        self.last = wave;
        self.level
    }
}
