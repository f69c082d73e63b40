//! Tests of `src/range.rs` from inside.

use super::*;

fn panel(points: Vec<(f64, f64)>) -> Panel {
    Panel { series: vec![Series::line("", 0, points)], ..Panel::default() }
}

fn common_ranges(panels: Vec<Panel>) -> Vec<Axes> {
    resolve(&Figure { columns: 2, share_y: ShareY::Rows, panels, ..Figure::default() })
}

#[test]
fn a_row_shares_the_union_of_what_is_in_view() {
    let mut late = panel(vec![(0.0, 900.0), (10.0, 3.0), (11.0, f64::NAN), (12.0, f64::INFINITY)]);
    late.x_range = Some((5.0, 20.0));
    let axes = common_ranges(vec![panel(vec![(0.0, -1.0), (1.0, 1.0)]), late, panel(vec![(0.0, 7.0), (1.0, 8.0)])]);
    assert_eq!(axes[0].y, axes[1].y);
    assert!(axes[0].y.lo < -1.0 && axes[0].y.hi > 3.0 && axes[0].y.hi < 4.0, "{:?}", axes[0].y);
    assert!(axes[2].y.lo > 6.0);
}

#[test]
fn a_run_that_diverges_does_not_flatten_the_others() {
    let mut wild = panel(vec![(0.0, 0.0), (1.0, 1e12)]);
    wild.off_scale = true;
    let axes = common_ranges(vec![panel(vec![(0.0, -1.0), (1.0, 1.0)]), wild.clone()]);
    assert_eq!(axes[0].y, axes[1].y);
    assert!(axes[0].y.hi < 2.0);
    assert!(common_ranges(vec![wild])[0].y.hi > 1e12, "alone it sets its own range");
}

#[test]
fn linear_and_logarithmic_panels_do_not_share() {
    let mut log = panel(vec![(0.0, 1e-3), (1.0, 1.0), (2.0, 0.0), (3.0, -4.0)]);
    log.log_y = true;
    let axes = common_ranges(vec![panel(vec![(0.0, -5.0), (1.0, 5.0)]), log]);
    assert!(axes[0].y.lo < -5.0 && axes[1].y.lo > 0.0 && axes[1].y.hi < 2.0);
}

#[test]
fn bars_stand_on_zero() {
    let bars = Panel { series: vec![Series::bars("", 0, vec![(0.0, 3.0), (1.0, 4.0)])], ..Panel::default() };
    assert_eq!(common_ranges(vec![bars])[0].y.lo, 0.0);
}
