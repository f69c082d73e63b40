//! Tests of `src/search.rs` from inside: on functions whose crossings are known in closed form.

use super::*;

/// A hump of height 1 and width 1 around 0.
fn hump(x: f64) -> f64 {
    (-x * x).exp()
}

/// Crossings of real eigenvalues with these logarithms, one part for each list, on a scan of `steps` from 0.5 to 1000.
fn found(steps: usize, logs: impl Fn(f64) -> Vec<Vec<f64>> + Sync) -> Found {
    let points: Vec<f64> = (0..=steps).map(|at| 0.5 + 999.5 * at as f64 / steps as f64).collect();
    crossings(&points, false, 1e-4, |(): &mut (), value, parts| {
        parts.extend(logs(value).into_iter().map(|mut part| {
            part.sort_by(|a, b| b.total_cmp(a));
            part.into_iter().map(|log| [log.exp(), 0.0]).collect()
        }));
        Ok(())
    })
    .unwrap()
}

fn assert_near(found: &Found, wanted: &[f64]) {
    assert_eq!(found.crossings.len(), wanted.len(), "{found:?}");
    for (crossing, wanted) in found.crossings.iter().zip(wanted) {
        assert!((crossing / wanted - 1.0).abs() <= 1e-4, "{crossing} for {wanted}");
    }
}

/// Three crossings take fewer radii than one of them by halving to the same tolerance on top of a scan.
#[test]
fn roots_of_a_cubic_take_few_radii() {
    let cubic = found(400, |x| vec![vec![(x - 200.0) * (x - 500.0) * (x - 700.0) * 1e-9]]);
    assert!(cubic.stable_at_start);
    assert_near(&cubic, &[200.0, 500.0, 700.0]);
    assert!(cubic.evaluations < 60, "{}", cubic.evaluations);
}

#[test]
fn what_never_crosses_takes_fewest() {
    for height in [-0.1, -1e-6, 0.1] {
        let flat = found(400, |x| vec![vec![height * (1.0 + 1e-3 * x)]]);
        assert!(flat.crossings.is_empty() && flat.stable_at_start == (height < 0.0));
        assert!(flat.evaluations < 40, "{}", flat.evaluations);
    }
}

/// Pockets of three steps, which the coarse points step over, are told by the eigenvalues below them.
#[test]
fn a_pocket_between_the_coarse_points_is_found() {
    for middle in [87.0, 333.0, 512.0, 801.0] {
        for sign in [1.0, -1.0] {
            let pocket = found(400, |x| vec![vec![sign * (0.1 * hump((x - middle) / 30.0) - 0.09)]]);
            let half = 30.0 * (1.0 / 0.9_f64).ln().sqrt();
            assert_near(&pocket, &[middle - half, middle + half]);
        }
    }
}

/// A branch that comes up from far below another one, which is flat.
#[test]
fn a_branch_from_below_is_seen_before_it_is_the_largest() {
    let branch = found(80, |x| vec![vec![-0.01, 0.04 - ((x - 430.0) / 300.0).powi(2)]]);
    assert_near(&branch, &[370.0, 490.0]);
}

/// A hump narrower than a step that its neighbours bulge towards.
#[test]
fn a_hump_between_two_points_is_climbed() {
    let hump = found(40, |x| vec![vec![1e-4 - ((x - 512.3) / 500.0).powi(2)]]);
    assert_near(&hump, &[507.3, 517.3]);
}

/// One part settles while another one gives way: stable between, and unstable at all points of the scan.
#[test]
fn a_window_between_two_parts_is_found() {
    let window = found(40, |x| vec![vec![(507.0 - x) * 1e-3], vec![(x - 517.0) * 1e-3]]);
    assert!(!window.stable_at_start);
    assert_near(&window, &[507.0, 517.0]);
}

#[test]
fn infinite_radii_are_closed_in_on_by_halving() {
    let steep = found(40, |x| vec![vec![if x < 600.0 { -0.1 } else { f64::INFINITY }]]);
    assert_near(&steep, &[600.0]);
}

/// Whole numbers: every one is looked at, and a crossing lies half way between two.
#[test]
fn whole_numbers_cross_between_two() {
    let points: Vec<f64> = (0..=20).map(f64::from).collect();
    let asked = |(): &mut (), value: f64, parts: &mut Vec<Polar>| {
        assert_eq!(value.fract(), 0.0);
        parts.push(vec![[if value == 7.0 { 1.5 } else { 0.5 }, 0.0]]);
        Ok(())
    };
    assert_eq!(crossings(&points, true, 1e-4, asked).unwrap().crossings, [6.5, 7.5]);
    let scarce = [0.0, 5.0, 10.0, 20.0];
    let asked = |(): &mut (), value: f64, parts: &mut Vec<Polar>| {
        assert_eq!(value.fract(), 0.0);
        parts.push(vec![[if value > 12.0 { 1.5 } else { 0.5 }, 0.0]]);
        Ok(())
    };
    assert_eq!(crossings(&scarce, true, 1e-4, asked).unwrap().crossings, [12.5]);
}
