//! Line time: of two ends the one that is behind goes farther, and the one that is ahead less far (THEORY §15).
//!
//! In motion at v the copies of a self-timed line stand (n₁ − n₂)·T_c·v apart, n the live ticks of an end: one that had to stand is
//! behind, for seconds. The samples that an end has heard and not emitted yet, k, say by how much: ½(k − k_far) = n_far − n. Either k
//! is as the newest packet left it, so that it is the same however many samples a packet brings. An end draws its slip to where that
//! way is made up for ([`super::carry`]), and the tank pays as for the rest of the slip. No end waits.
//!
//! k is told modulo [`MODULUS`], beside ρ. Ways of different delay bias it by half their difference, as any clock without a reference,
//! within [`EVEN`].

use crate::num::Scalar;
use crate::settings::{Key, Settings};

pub(super) const EVEN: Key = Key::number("coordination.even_s", 0.0, [0.0, 0.1], "s")
    .means("Self-timed line: how much of the line's own time at most an end makes up for that is behind the other; 0: nothing.");

/// Of two numbers of samples that are less than half of this apart the difference is known.
const MODULUS: i32 = 4096;
/// What is told of ρ is less.
const STEP: i32 = 4;
/// What is told is less, and has 24 bits; without samples in it, it is at most 2.
pub(super) fn most_told(settings: &Settings) -> f64 {
    if settings.own(&EVEN) > 0.0 { f64::from(STEP * MODULUS) } else { 2.0 }
}

/// How an end makes up for line time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Even<S> {
    /// The most, s.
    most_s: S,
    /// ½·T_c, s.
    half_period_s: S,
}

configured!([S: Scalar] Even<S> { most_s, half_period_s });

impl<S: Scalar> Even<S> {
    pub(super) fn build(settings: &Settings) -> Self {
        let half_period_s = S::from_f64(0.5 * settings.timing.control_period_s);
        Self { most_s: S::from_f64(settings.own(&EVEN)), half_period_s }
    }

    /// What a packet says of ρ and of so many samples.
    pub(super) fn packet_field(&self, share: S, samples: u16) -> S {
        if self.most_s == S::ZERO { share } else { share + S::from_i32(STEP * (i32::from(samples) % MODULUS)) }
    }

    /// What it says of ρ, and how many samples.
    pub(super) fn receive(&self, told: S) -> (S, u16) {
        let (samples, share) = told.apart(STEP, MODULUS - 1);
        (share, samples as u16)
    }

    /// By how much an end with so many samples outstanding is behind one that told `far`, s.
    #[inline]
    pub(super) fn behind_s(&self, own: u16, far: u16) -> S {
        // Within half of the modulus to either side.
        let more = (i32::from(own) - i32::from(far) + MODULUS / 2).rem_euclid(MODULUS) - MODULUS / 2;
        (self.half_period_s * S::from_i32(more)).limit(self.most_s)
    }
}
