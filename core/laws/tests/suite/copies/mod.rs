//! Two copies that a law holds together, hands and packets prescribed: each law's own promise, and numbers of the paper it comes from.

mod average_position;
mod fractal_impedance;
mod model_mediated;
mod passivity_observer;
mod remote_dynamic_proxy;

use crate::two_copies::PERIOD;

/// Period of what crosses zero upward at these times, s.
fn period(values: &[f64]) -> f64 {
    let crossings: Vec<f64> = values
        .windows(2)
        .enumerate()
        .filter(|(_, pair)| pair[0] < 0.0 && pair[1] >= 0.0)
        .map(|(at, pair)| (at as f64 - pair[0] / (pair[1] - pair[0])) * PERIOD)
        .collect();
    (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64
}

/// Numbers of −0.5 to 0.5, the same for the same seed.
fn draws(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }
}
