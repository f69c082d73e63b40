//! Paired differences by hand.

use super::*;
use crate::sweep::METRICS;

/// Runs with these values of the first figure of merit.
fn runs(point: usize, values: &[f64]) -> Vec<Row> {
    let row = |(seed, value): (u32, &f64)| {
        let mut metrics = [f64::NAN; METRICS.len()];
        metrics[0] = *value;
        let reason = if value.is_nan() { format!("seed {seed} failed") } else { String::new() };
        let verdict = if value.is_nan() { "NO" } else { "stable" }.to_owned();
        Row {
            point,
            seed,
            verdict,
            reason,
            spectral_radius: 0.9,
            unstable_modes: String::new(),
            metrics,
            state_hash: format!("{value}"),
        }
    };
    (1..).zip(values).map(row).collect()
}

/// 1, ½, 1½, 1: mean 1, variance 1/6, t = 3.182446 with 3 degrees of freedom. The values themselves spread ten times as far.
#[test]
fn the_interval_is_that_of_the_pairs() {
    let (first, this) = (runs(0, &[1.0, 12.0, 23.0, 34.0]), runs(1, &[2.0, 12.5, 24.5, 35.0]));
    let one = Paired::of(&[[&first, &this]], 0);
    let found = one.difference.expect("a difference");
    assert_eq!((found.mean, one.means), (1.0, [Some(17.5), Some(18.5)]));
    let want = 3.182_446_305 * (1.0_f64 / 6.0 / 4.0).sqrt();
    assert!((found.within_95.expect("an interval") - want).abs() < 1e-8, "{found:?} is not ± {want}");
    assert_eq!(one.differs(), Some(true));
}

/// An interval that holds 0 tells nothing apart; no difference at all is exactly 0.
#[test]
fn what_is_not_told_apart() {
    let (first, this) = (runs(0, &[1.0, 2.0, 3.0]), runs(1, &[2.0, 1.0, 3.5]));
    assert_eq!(Paired::of(&[[&first, &this]], 0).differs(), Some(false));
    let same = Paired::of(&[[&first, &first]], 0);
    assert_eq!(same.difference, Some(Estimate { mean: 0.0, within_95: Some(0.0) }));
    assert_eq!(same.differs(), Some(false));
}

/// Where every seed gives the same run there is no interval, and any difference is one.
#[test]
fn nothing_random_has_no_interval() {
    let (first, this) = (runs(0, &[1.0, 1.0]), runs(1, &[1.5, 1.5]));
    let one = Paired::of(&[[&first, &this]], 0);
    assert_eq!(one.difference, Some(Estimate { mean: 0.5, within_95: None }));
    assert_eq!(one.differs(), Some(true));
}

/// One run that failed, of either: no mean of the others.
#[test]
fn a_failed_run_is_never_averaged() {
    let (whole, failed) = (runs(0, &[1.0, 2.0, 3.0]), runs(1, &[1.0, f64::NAN, 3.0]));
    for (pair, means) in [([&whole, &failed], [Some(2.0), None]), ([&failed, &whole], [None, Some(2.0)])] {
        let one = Paired::of(&[pair.map(Vec::as_slice)], 0);
        assert_eq!((one.difference, one.means, one.differs()), (None, means, None));
    }
}
