//! Tests of `src/trace.rs` from inside.

use super::*;

const FRAME: Frame = Frame { left: 0.0, top: 0.0, right: 100.0, bottom: 50.0 };

/// A signal that looks random and is the same everywhere.
fn noise(count: usize) -> Vec<Point> {
    let mut state = 12345_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state) / f64::from(u32::MAX)
    };
    (0..count).map(|i| (i as f64 * 100.0 / count as f64, 50.0 * random())).collect()
}

#[test]
fn thinning_keeps_the_extremes_of_every_column() {
    let points = noise(20_000);
    let kept = thinned(&points);
    assert!(kept.len() <= 2 * 100 + 2, "{}", kept.len());
    for column in 0..100 {
        let brute = |points: &[Point], pick: fn(f64, f64) -> f64| {
            points.iter().filter(|p| p.0.floor() as i32 == column).map(|p| p.1).reduce(pick)
        };
        assert_eq!(brute(&kept, f64::min), brute(&points, f64::min), "column {column}");
        assert_eq!(brute(&kept, f64::max), brute(&points, f64::max), "column {column}");
    }
    let mut rest = points.iter();
    assert!(kept.iter().all(|k| rest.any(|p| p == k)), "a subsequence, in the same order");
}

#[test]
fn short_lines_stay_as_they_are() {
    let points = vec![(0.0, 1.0), (10.5, 3.0), (10.7, 2.0), (20.0, 2.0)];
    assert_eq!(thinned(&points), points);
    assert!(thinned(&[]).is_empty());
}

#[test]
fn gaps_split_and_the_frame_cuts() {
    let points = [(0.0, 10.0), (10.0, 10.0), (20.0, f64::NAN), (30.0, 10.0), (40.0, 100.0), (50.0, 10.0)];
    let pieces = polylines(&points, &FRAME);
    assert_eq!(pieces.len(), 3);
    assert_eq!(pieces[0], [(0.0, 10.0), (10.0, 10.0)]);
    for (x, y) in pieces.iter().flatten() {
        assert!(FRAME.grown(1e-9).contains((*x, *y)), "{x} {y}");
    }
    assert!((pieces[1][1].0 - (30.0 + 10.0 * 40.0 / 90.0)).abs() < 1e-9);
}

#[test]
fn a_line_to_infinity_leaves_through_the_edge() {
    let pieces = polylines(&[(0.0, 25.0), (50.0, 25.0), (51.0, f64::NEG_INFINITY), (52.0, 1e308)], &FRAME);
    assert!(pieces.iter().flatten().all(|p| FRAME.grown(1e-6).contains(*p)), "{pieces:?}");
    assert!(pieces[0].last().is_some_and(|p| p.1 < 1e-6), "{pieces:?}");
}

#[test]
fn strokes_and_gaps_have_the_lengths_of_the_pattern() {
    let strokes = dashes(&[(0.0, 0.0), (5.0, 0.0), (20.0, 0.0)], &[6.0, 4.0]);
    assert_eq!(strokes, [vec![(0.0, 0.0), (5.0, 0.0), (6.0, 0.0)], vec![(10.0, 0.0), (16.0, 0.0)]]);
    assert_eq!(dashes(&[(0.0, 0.0), (9.0, 0.0)], &[]), [vec![(0.0, 0.0), (9.0, 0.0)]]);
    assert!(dashes(&[], &[1.0, 1.0]).is_empty());
}
