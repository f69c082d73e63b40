//! What the wave line between two peers makes of a wave, without network and peers: filter, one sample in M, hold for M ticks.
//!
//! The channel is passive if no wave comes out with more energy than went in. Its worst wave is known in closed form: y = Σ h_k·u of the
//! newest samples is largest, for their energy, where u repeats h, newest sample last (Cauchy–Schwarz, over the packets: h_p summed over
//! whole packet periods, which for one pole is again proportional to a^p). For the paper's filter, a = e^(−Ω_c·T_c), that is
//!
//! > energy out/energy in = M·(1 − a)(1 + a^M)/((1 + a)(1 − a^M)),
//!
//! 1.64 with M = 8 and 60 Hz; without a filter M; of the mean 1. What is driven here are the filters that fly.

use std::f64::consts::TAU;

use cohold_core::law::decimate::Decimator;
use cohold_core::settings::Settings;

/// Packets that a wave lasts, of which the last half is counted.
const PACKETS: usize = 2000;

/// Energy out over energy in of this wave, √W by tick.
fn out_over_in<D: Decimator<f64>>(settings: &Settings, wave: impl Fn(usize) -> f64) -> f64 {
    let (filter, mut state) = (D::build(settings), D::State::default());
    let ticks = settings.timing.ticks_per_packet as usize;
    let (mut came, mut went) = (0.0, 0.0);
    for packet in 0..PACKETS {
        let counts = packet >= PACKETS / 2;
        for tick in packet * ticks..(packet + 1) * ticks {
            let sample = wave(tick);
            filter.push(&mut state, sample);
            came += if counts { sample * sample } else { 0.0 };
        }
        let sent = filter.level(&state);
        went += if counts { ticks as f64 * sent * sent } else { 0.0 };
    }
    went / came
}

/// Of the worst wave that the filter `a^p`, p samples ago, has: a = 0 for the newest sample alone, 1 for the mean.
pub(super) fn worst<D: Decimator<f64>>(settings: &Settings, a: f64) -> f64 {
    let ticks = settings.timing.ticks_per_packet as usize;
    out_over_in::<D>(settings, |tick| a.powi((ticks - 1 - tick % ticks) as i32))
}

/// e^(−Ω_c·T_c) of the paper's filter.
pub(super) fn pole(settings: &Settings) -> f64 {
    (-TAU * settings.coordination.cutoff_hz * settings.timing.control_period_s).exp()
}

/// Of one tone of this frequency, Hz.
pub(super) fn tone<D: Decimator<f64>>(settings: &Settings, hz: f64) -> f64 {
    let step = TAU * hz * settings.timing.control_period_s;
    // A phase at which no frequency is sampled at its zeros alone.
    out_over_in::<D>(settings, |tick| (step * tick as f64 + 1.0).sin())
}

#[cfg(test)]
#[path = "../../tests/inside/channel.rs"]
mod tests;
