//! Tests of `src/quantiles.rs` from inside.

use super::*;

#[test]
fn quantiles_are_those_of_the_sorted_samples() {
    assert_eq!(Times::default().quantiles(), Quantiles::default());
    // From 0 ns to 8 ms, and one beyond everything.
    let mut samples: Vec<u64> =
        (0..20_000_u64).map(|at| at * at * at % 7_919_001 + at % 90).chain([u64::MAX]).collect();
    let mut times = Times::default();
    samples.iter().for_each(|ns| times.add(*ns));
    samples.sort_unstable();
    let got = times.quantiles();
    let quantiles = [(0.5, got.p50_us), (0.9, got.p90_us), (0.99, got.p99_us), (0.999, got.p999_us)];
    for (fraction, got_us) in quantiles {
        let want_us = 1e-3 * samples[(fraction * samples.len() as f64).ceil() as usize - 1] as f64;
        assert!(got_us >= want_us && got_us <= want_us * (1.0 + 1.0 / 64.0), "{fraction}: {got_us} for {want_us}");
    }
    assert_eq!((got.samples, got.largest_us), (20_001, 1e-3 * u64::MAX as f64));
}
