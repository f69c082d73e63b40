//! Tests of `src/scale.rs` from inside.

use super::*;

fn labels(lo: f64, hi: f64, log: bool) -> Vec<String> {
    Scale::new((lo, hi), log).ticks(5).into_iter().map(|(_, text)| text).collect()
}

#[test]
fn ticks_are_round_and_labels_tell_them_apart() {
    assert_eq!(labels(0.0, 1.0, false), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
    assert_eq!(labels(-0.5, 0.5, false), ["−0.4", "−0.2", "0", "0.2", "0.4"]);
    assert_eq!(labels(34.0, 36.0, false), ["34.0", "34.5", "35.0", "35.5", "36.0"]);
    assert_eq!(labels(0.0, 12000.0, false), ["0", "5000", "10000"]);
    assert_eq!(labels(0.0, 4e6, false), ["0", "1×10^6", "2×10^6", "3×10^6", "4×10^6"]);
    assert_eq!(labels(-1e-6, 1e-6, false), ["−1.0×10^−6", "−0.5×10^−6", "0", "0.5×10^−6", "1.0×10^−6"]);
}

#[test]
fn logarithmic_ticks_are_decades_or_their_parts() {
    assert_eq!(labels(1e-3, 10.0, true), ["0.001", "0.01", "0.1", "1", "10"]);
    assert_eq!(labels(0.8, 60.0, true), ["1", "2", "5", "10", "20", "50"]);
    assert_eq!(labels(1e-8, 1e-5, true), ["10^−8", "10^−7", "10^−6", "10^−5"]);
    assert_eq!(labels(4e-6, 1.5e-4, true), ["5×10^−6", "10^−5", "2×10^−5", "5×10^−5", "10^−4"]);
    assert_eq!(labels(3.0, 4.0, true), ["3.0", "3.2", "3.4", "3.6", "3.8", "4.0"]);
    assert_eq!(Scale::new((1.0, 100.0), true).minor_ticks().len(), 16);
}

#[test]
fn every_range_gives_a_usable_scale() {
    let odd = [0.0, -0.0, 1e-320, 1.0, -1.0, 1e-300, 1e300, 1e308, -1e308, f64::NAN, f64::INFINITY, 1.0 + 1e-15];
    for (a, b) in odd.iter().flat_map(|a| odd.map(|b| (*a, b))) {
        for log in [false, true] {
            let scale = Scale::new((a, b), log);
            assert!(scale.lo < scale.hi, "{a} {b} {scale:?}");
            let wide = scale.widened(0.05, 0.3);
            for s in [scale, wide] {
                assert!(s.lo.is_finite() && s.hi.is_finite() && s.lo < s.hi, "{a} {b} {s:?}");
                let ticks = s.ticks(5);
                assert!(ticks.len() < 60 && ticks.iter().all(|(v, _)| v.is_finite()), "{a} {b} {ticks:?}");
                let _ = s.minor_ticks();
            }
        }
    }
}

/// One tick is no scale.
#[test]
fn an_axis_has_two_ticks_at_least() {
    for (range, log, count) in
        [((1.17, 9.73), false, 4), ((200.0, 45_000.0), true, 2), ((1.6, 9.0), true, 2), ((0.31, 0.39), false, 1)]
    {
        let ticks = Scale::new(range, log).ticks(count);
        assert!(ticks.len() >= 2, "{range:?}: {ticks:?}");
        assert!(ticks.iter().all(|(value, _)| (range.0..=range.1).contains(value)));
    }
}
