//! Tests of `src/legend.rs` from inside.

use super::*;

const FRAME: Frame = Frame { left: 100.0, top: 50.0, right: 600.0, bottom: 350.0 };

fn panel() -> Panel {
    let series = vec![Series::line("local copy", 0, vec![]), Series::line("remote copy", 1, vec![])];
    Panel { series, note: Some("diverges".to_owned()), ..Panel::default() }
}

#[test]
fn an_empty_panel_has_its_legend_at_the_top_right() {
    let spot = place(&panel(), &FRAME, &[]).unwrap();
    assert_eq!((spot.area.right, spot.area.top), (FRAME.right - CLEARANCE, FRAME.top + CLEARANCE));
    assert!(place(&Panel::default(), &FRAME, &[]).is_none());
}

#[test]
fn a_legend_moves_away_from_data() {
    let top_right: Vec<Point> =
        (300..600).flat_map(|x| (50..250).step_by(9).map(move |y| (x as f64, y as f64))).collect();
    let spot = place(&panel(), &FRAME, &top_right).unwrap();
    assert_eq!(spot.covered, 0);
    assert!(!top_right.iter().any(|p| spot.area.contains(*p)));
    assert!(FRAME.contains((spot.area.left, spot.area.top)) && FRAME.contains((spot.area.right, spot.area.bottom)));
}

#[test]
fn a_full_panel_reports_what_is_covered() {
    let full: Vec<Point> = (100..600).flat_map(|x| (50..350).step_by(9).map(move |y| (x as f64, y as f64))).collect();
    assert!(place(&panel(), &FRAME, &full).unwrap().covered > 0);
    assert!(headroom(&panel(), &FRAME) > 0.2);
}
