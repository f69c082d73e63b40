//! Decimation filters: from the outgoing wave at the control rate they form the one sample in M ticks that is sent.
//!
//! [`Newest`] sends the last sample as it is: traditional wave communications, which alias.
//! [`OnePole`] is the paper's anti-aliasing filter, ẋ_f = −Ω_c·x_f + u_out, y = Ω_c·x_f (eq. 1), discretised exactly for
//! a held input: y ← e^(−Ω_c·T_c)·y + (1 − e^(−Ω_c·T_c))·u_out. Unconditionally stable, unit gain at rest; passive only in
//! the band it passes. [`Mean`] sends ū, the mean of the last M samples: held for M ticks it never emits more than was
//! absorbed, M·ū² ≤ Σu² (Cauchy–Schwarz; THEORY §5), whatever the signal.

use super::{LawInfo, Promise};
use crate::num::{Configured, Scalar, StateVector};
use crate::settings::Settings;

/// A filter in front of the decimation to one wave sample per packet.
pub trait Decimator<S: Scalar>: Configured + Copy + core::fmt::Debug + Send + Sync + 'static {
    /// Name, keys and promises of the wave law that sends through this filter.
    const INFO: LawInfo;
    /// Whether the samples sent, each held for M ticks, keep the integral of the wave.
    const KEEPS_INTEGRAL: bool = false;
    /// State of the filter.
    type State: StateVector<S> + Copy + core::fmt::Debug + Default + Send + Sync;

    /// The filter of the scene's settings.
    fn build(settings: &Settings) -> Self;
    /// Takes in one sample of the outgoing wave, √W.
    fn push(&self, state: &mut Self::State, wave: S);
    /// The wave that would be sent now, √W.
    fn level(&self, state: &Self::State) -> S;
}

/// No filter: the newest sample of the wave is sent.
#[derive(Clone, Copy, Debug)]
pub struct Newest;

configured!([] Newest {});

impl<S: Scalar> Decimator<S> for Newest {
    const INFO: LawInfo = LawInfo {
        name: "wave",
        gains: &["coordination.stiffness_n_per_m=1590"],
        source: "Rakhsha & Constantinescu 2012, §2",
        ..LawInfo::WAVES
    };
    type State = S;
    fn build(_: &Settings) -> Self {
        Self
    }
    #[inline]
    fn push(&self, level: &mut S, wave: S) {
        *level = wave;
    }
    #[inline]
    fn level(&self, level: &S) -> S {
        *level
    }
}

/// The one-pole low-pass filter of the paper.
#[derive(Clone, Copy, Debug)]
pub struct OnePole<S> {
    /// e^(−Ω_c·T_c).
    keep: S,
    /// 1 − e^(−Ω_c·T_c).
    take: S,
}

configured!([S: Scalar] OnePole<S> { keep, take });

impl<S: Scalar> Decimator<S> for OnePole<S> {
    const INFO: LawInfo = LawInfo {
        name: "passive-wave",
        source: "Rakhsha & Constantinescu 2012, eq. 1",
        ..<Newest as Decimator<S>>::INFO
    };
    type State = S;
    fn build(settings: &Settings) -> Self {
        let angle = core::f64::consts::TAU * settings.coordination.cutoff_hz * settings.timing.control_period_s;
        Self { keep: S::from_f64(libm::exp(-angle)), take: S::from_f64(-libm::expm1(-angle)) }
    }
    #[inline]
    fn push(&self, level: &mut S, wave: S) {
        *level = self.keep * *level + self.take * wave;
    }
    #[inline]
    fn level(&self, level: &S) -> S {
        *level
    }
}

/// The mean of the samples since the last packet.
#[derive(Clone, Copy, Debug)]
pub struct Mean<S> {
    samples: u32,
    /// 1/M.
    share: S,
}

configured!([S: Scalar] Mean<S> { samples, share });

/// State of a mean: sum and number of the samples so far, and the last mean that was complete.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeanState<S> {
    sum: S,
    level: S,
    count: u32,
}

visited!([S: Scalar] MeanState<S> { sum, level });

impl<S: Scalar> Decimator<S> for Mean<S> {
    const INFO: LawInfo = LawInfo {
        name: "passive-mean",
        source: "THEORY §5",
        promises: &[Promise::PassiveOnConstantDelay],
        ..<Newest as Decimator<S>>::INFO
    };
    const KEEPS_INTEGRAL: bool = true;
    type State = MeanState<S>;
    fn build(settings: &Settings) -> Self {
        let samples = settings.timing.ticks_per_packet;
        Self { samples, share: S::from_f64(1.0 / f64::from(samples)) }
    }
    #[inline]
    fn push(&self, state: &mut MeanState<S>, wave: S) {
        state.sum = state.sum + wave;
        state.count += 1;
        // Packets leave every M ticks, so a mean is whole when the next one is due.
        if state.count >= self.samples {
            state.level = state.sum * self.share;
            state.sum = S::ZERO;
            state.count = 0;
        }
    }
    #[inline]
    fn level(&self, state: &MeanState<S>) -> S {
        state.level
    }
}
