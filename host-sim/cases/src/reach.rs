//! A hand's reach with tremor, read through an encoder.
//!
//! A minimum-jerk reach (Flash & Hogan 1985) of 50 mm in one second with a tremor of 0.1 mm at 9 Hz that goes on for
//! another second: the motion of `scenes/person-reach.toml`. What is made of it: [the estimators](../../estimators/index.html).
//! Unit: m, m/s, counts/m.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::f64::consts::TAU;

use cohold_core::device::encoder::{Counts, Encoder, EncoderState};
use cohold_core::device::velocity::VelocityName;
use cohold_core::num::{Motion, Scalar};
use cohold_core::settings::{Choice, Settings};

/// Encoder resolutions, counts/m: 50 µm, 16 bit, 5 µm (the default), 24 bit.
pub const RESOLUTIONS: [f64; 4] = [20_000.0, 65_536.0, 200_000.0, 16_777_216.0];
/// Ticks of the motion: 2 s.
pub const TICKS: usize = 2000;

/// A device with this encoder and this estimator.
pub fn settings(velocity: VelocityName, counts_per_m: f64) -> Settings {
    let mut settings = Settings::default();
    settings.axis.velocity = velocity;
    settings.encoder.counts_per_m = counts_per_m;
    settings
}

/// Where the hand is (m) and how fast (m/s) at `time_s`.
pub fn hand(time_s: f64) -> Motion<f64> {
    const REACH_M: f64 = 0.05;
    const TREMOR_M: f64 = 1e-4;
    const TREMOR_RAD_PER_S: f64 = TAU * 9.0;
    // Seconds are fractions of the reach: it takes one.
    let s = time_s.min(1.0);
    let (sine, cosine) = libm::sincos(TREMOR_RAD_PER_S * time_s);
    Motion {
        position: REACH_M * s * s * s * (10.0 + s * (-15.0 + 6.0 * s)) + TREMOR_M * sine,
        velocity: REACH_M * 30.0 * s * s * (1.0 - s) * (1.0 - s) + TREMOR_M * TREMOR_RAD_PER_S * cosine,
    }
}

/// What the estimator is given each tick, and the true velocity (m/s) then.
pub fn readings<S: Scalar>(settings: &Settings) -> Vec<(Motion<S>, f64)> {
    let encoder = Encoder::<S>::build(settings);
    let mut state = EncoderState::default();
    let read = |tick: usize| {
        let hand = hand(tick as f64 * settings.timing.control_period_s);
        let counts = Counts(libm::floor(hand.position * settings.encoder.counts_per_m) as i64 as u16);
        // No step of this motion is implausible; were one, the position would stand still and the error show it.
        let position = encoder.step(&mut state, counts).unwrap_or(S::ZERO);
        (Motion::at(position), hand.velocity)
    };
    (0..TICKS).map(read).collect()
}

/// The case whose calls are counted: what an estimator costs may depend on what it sees.
pub fn case(velocity: VelocityName, counts_per_m: f64) -> String {
    format!("velocity/{}/{counts_per_m:.0}", velocity.name())
}
