//! Line time: of two ends the one that is behind goes farther, and the one that is ahead less far (THEORY §15).
//!
//! In motion at v the copies of a self-timed line stand (n₁ − n₂)·T_c·v apart, n the live ticks of an end: one that had to stand is behind, for
//! seconds. The samples that an end has heard and not emitted yet, k, say by how much: ½(k − k_far) = n_far − n, with either k at the end of a packet's ticks, as it is told. An end draws its slip to where
//! that way is made up for ([`super::carry`]), and the tank pays as for the rest of the slip. No end waits.
//!
//! k is told modulo [`MODULUS`], beside ρ. Ways of different delay bias it by half their difference, as any clock without a reference, within [`EVEN`]; so do packets
//! that both ends send at different times of a packet period.

use crate::num::Scalar;
use crate::settings::{Key, Settings};

pub(super) const EVEN: Key = Key::whole("coordination.even_ticks", 0, [0, 60], "ticks")
    .means("Self-timed line: by how many ticks of the line's own time at most an end that is behind the other makes up for it; 0: not at all.");

/// Of two numbers of samples that are less than half of this apart the difference is known.
const MODULUS: i32 = 256;
/// What is told of ρ is less.
const STEP: i32 = 4;
/// What is told is less; without samples in it, at most 2.
pub(in crate::law) fn most_told(settings: &Settings) -> f64 {
    (settings.own(&EVEN) * f64::from(STEP * MODULUS)).clamp(2.0, f64::from(STEP * MODULUS))
}

/// How an end makes up for line time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Even<S> {
    /// Twice the most ticks.
    most: S,
    /// ½·T_c, s.
    half_period_s: S,
}

configured!([S: Scalar] Even<S> { most, half_period_s });

impl<S: Scalar> Even<S> {
    pub(super) fn build(settings: &Settings) -> Self {
        let half_period_s = S::from_f64(0.5 * settings.timing.control_period_s);
        Self { most: S::from_f64(2.0 * settings.own(&EVEN)), half_period_s }
    }

    /// What a packet says of ρ and of so many samples.
    pub(super) fn says(&self, share: S, samples: u8) -> S {
        if self.most == S::ZERO { share } else { share + S::from_i32(STEP * i32::from(samples)) }
    }

    /// What it says of ρ, and how many samples.
    pub(super) fn hears(&self, told: S) -> (S, u8) {
        if self.most == S::ZERO {
            return (told, 0);
        }
        let samples = (told.round_to_i32() / STEP).clamp(0, MODULUS - 1);
        (told - S::from_i32(STEP * samples), samples as u8)
    }

    /// By how much an end with so many samples outstanding is behind one that told `far`, s.
    #[inline]
    pub(super) fn behind_s(&self, own: u8, far: u8) -> S {
        if self.most == S::ZERO {
            return S::ZERO;
        }
        let more = i32::from(own.wrapping_sub(far).cast_signed());
        self.half_period_s * S::from_i32(more).limit(self.most)
    }
}
