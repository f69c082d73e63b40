//! Discretisations of the wave's anti-aliasing filter Ω_c/(s + Ω_c), in the band that packets can carry.
//!
//! | choice | y\[n\] | in core |
//! |---|---|---|
//! | exact | e^(−ΩT)·y\[n−1\] + (1 − e^(−ΩT))·u\[n\] | yes |
//! | forward Euler | y\[n−1\] + ΩT·(u\[n\] − y\[n−1\]) | no, here for comparison |
//! | bilinear | ((2 − ΩT)·y\[n−1\] + ΩT·(u\[n\] + u\[n−1\]))/(2 + ΩT) | no, here for comparison |
//!
//! The response is measured, not derived: the impulse response, run through core's own filter, is summed at each
//! frequency. What a peer sends at tick n is y\[n−1\], so that is the instant at which gain and phase are compared;
//! the gain alone says what passes, whenever. 1000 frequencies up to the packet Nyquist 1/(2·M·T_c): 62.5 Hz with the
//! paper's cutoff of 60 Hz, and 250 Hz with the cutoff that its rule (π/M of the sample rate) gives for M = 2.
//! Pure numbers.

use std::f64::consts::TAU;

use cohold_cases::filters::angle;
use cohold_core::num::Scalar;
use cohold_core::settings::{Refused, Settings};
use cohold_sim::measure::impedance::Complex;

use super::{Comparison, Family, counts::Processor, rms};

pub use cohold_cases::filters::{Bilinear, Exact, Filter, ForwardEuler};

/// RMS over the band of (relative error of gain and phase, relative error of the gain alone).
pub fn errors<S: Scalar, F: Filter<S>>(settings: &Settings) -> (f64, f64) {
    const FREQUENCIES: usize = 1000;
    let mut filter = F::build(settings);
    // 60 dB in 18 time constants is not enough; 40 of them leave e^−40.
    let ticks = (40.0 / angle(settings)).ceil() as usize + 2;
    let impulse: Vec<f64> =
        (0..ticks).map(|tick| filter.push(if tick == 0 { S::ONE } else { S::ZERO }).to_f64()).collect();
    let (period_s, cutoff) = (settings.timing.control_period_s, TAU * settings.coordination.cutoff_hz);
    let nyquist_hz = 0.5 / (period_s * f64::from(settings.timing.ticks_per_packet));
    let error = |at: usize| {
        let angular = TAU * nyquist_hz * at as f64 / FREQUENCIES as f64;
        // What is sent is a tick old.
        let sent =
            (1..).zip(&impulse).map(|(tick, value)| Complex::cis(angular * period_s * f64::from(tick)).conj() * value);
        let ratio = sent.sum::<Complex>() / (Complex::from(cutoff) / Complex::new(cutoff, angular));
        ((ratio - 1.0).norm(), ratio.norm() - 1.0)
    };
    let (both, gains): (Vec<f64>, Vec<f64>) = (1..=FREQUENCIES).map(error).unzip();
    (rms(both), rms(gains))
}

pub(super) fn measure(processor: Processor) -> Result<Family, Refused<'static>> {
    let paper = Settings::default();
    let mut quick = paper;
    (quick.timing.ticks_per_packet, quick.coordination.cutoff_hz) = (2, 250.0);
    let measure = |settings: &Settings| {
        let count = |name: &str| processor.count(&format!("filter/{name}"), "f32");
        [
            (Exact::<f32>::NAME, errors::<f32, Exact<f32>>(settings)),
            (ForwardEuler::<f32>::NAME, errors::<f32, ForwardEuler<f32>>(settings)),
            (Bilinear::<f32>::NAME, errors::<f32, Bilinear<f32>>(settings)),
        ]
        .map(|(name, errors)| (name.to_owned(), errors, count(name)))
    };
    let both = |title: &str, measured: &[(String, (f64, f64), Option<u64>)]| {
        [
            Comparison::of(title, "RMS gain error", "1", measured, |errors| errors.1),
            Comparison::of(title, "RMS error of gain and phase", "1", measured, |errors| errors.0),
        ]
    };
    let comparisons = [both("cutoff 60 Hz, M = 8", &measure(&paper)), both("cutoff 250 Hz, M = 2", &measure(&quick))];
    let comparisons = comparisons.concat();
    let (gain, sent, quick) = (&comparisons[0], &comparisons[1], &comparisons[2]);
    let all = |comparison: &Comparison| {
        ["exact", "bilinear", "forward-euler"]
            .map(|name| format!("{:.1} %", 100.0 * comparison.error_of(name)))
            .join(", ")
    };
    let insight = format!(
        "Exact, bilinear, forward Euler: the gain errs by {} at 60 Hz and by {} at 250 Hz, gain and phase by {} at 60 Hz, \
         most of it the half tick for which a sample is held and, in the bilinear one, the tick it waits to be sent. Forward \
         Euler's phase gains what its gain loses and it breaks at 318 Hz: take exact, for {:+} instructions a sample.",
        all(gain),
        all(quick),
        all(sent),
        gain.instructions_of("exact") as i64 - gain.instructions_of("forward-euler") as i64,
    );
    Ok(Family {
        name: "filter",
        title: "Discretisation of the wave's filter",
        motion: "Cutoff 60 Hz and 250 Hz at 1 kHz; response from 0 to the packet Nyquist, 62.5 Hz and 250 Hz; f32"
            .to_owned(),
        reference: "the continuous filter Ω_c/(jω + Ω_c)",
        instructions_per: "sample",
        comparisons,
        headline: 0,
        insight,
    })
}
