//! Tests of `src/data.rs` from inside.

use super::*;
use crate::{Print, Strip, layout};

/// The lines of the table of a figure with one panel.
fn table(panel: Panel) -> Vec<String> {
    let figure = Figure { panels: vec![panel], ..Figure::default() };
    layout::sheet(&figure, Print::default()).unwrap().data.lines().map(str::to_owned).collect()
}

#[test]
fn every_shape_has_its_rows() {
    let series = vec![
        Series::line("held, with a comma", 0, vec![(0.0, 1.0), (1.0, -2.5)]),
        Series::dots("", 1, vec![(0.5, 3.0), (1.0, 4.0)], vec!["first".to_owned()]),
        Series::intervals("mean", 2, vec![(0.25, 2.0, 0.5)]),
        Series::region(
            "stable",
            3,
            vec![
                Strip { left: (0.0, 0.0, 1.0), right: (1.0, 0.0, 2.0) },
                Strip { left: (1.0, 0.0, 2.0), right: (2.0, 1.25e-17, 3.0) },
            ],
        ),
    ];
    let panel = Panel {
        title: "Two\nlines".to_owned(),
        x_label: "Time (s)".to_owned(),
        y_label: "Force (N)".to_owned(),
        series,
        ..Panel::default()
    };
    let expected = [
        "# panel 1: Two lines; x: Time (s); y: Force (N)",
        "panel,series,name,x,y,low,high",
        "1,\"held, with a comma\",,0,1,,",
        "1,\"held, with a comma\",,1,-2.5,,",
        "1,,first,0.5,3,,",
        "1,,,1,4,,",
        "1,mean,,0.25,2,1.5,2.5",
        "1,stable,,0,,0,1",
        "1,stable,,1,,0,2",
        "1,stable,,2,,1.25e-17,3",
    ];
    assert_eq!(table(panel), expected);
    let bars = vec![Series::bars("here", 0, vec![(0.0, 3.5), (1.0, 0.1)])];
    let named = Panel { categories: vec!["power".to_owned(), "wave".to_owned()], series: bars, ..Panel::default() };
    assert_eq!(table(named)[2..], ["1,here,power,0,3.5,,", "1,here,wave,1,0.1,,"]);
}

/// A dense line keeps its extremes and its ends, a gap stays a gap, and a figure that shows nothing has no table.
#[test]
fn a_dense_line_is_thinned_to_what_is_seen() {
    let mut points: Vec<(f64, f64)> = (0..100_000).map(|i| (f64::from(i), f64::from(i % 97) / 3.0)).collect();
    points[50_001].1 = 1e3;
    points[70_000].1 = f64::NAN;
    let rows = table(Panel { series: vec![Series::line("dense", 0, points)], ..Panel::default() });
    assert!(rows.len() > 1_000 && rows.len() < 4_000, "{}", rows.len());
    for wanted in ["1,dense,,0,0,,", "1,dense,,50001,1000,,", "1,dense,,70000,NaN,,", "1,dense,,99999,29.66667,,"] {
        assert!(rows.iter().any(|row| row == wanted), "{wanted}");
    }
    let line = Series::line("", 0, (0..10).map(|i| (f64::from(i), 0.0)).collect());
    let rows = table(Panel { x_range: Some((2.5, 4.0)), series: vec![line], ..Panel::default() });
    assert_eq!(rows[2..], ["1,,,2,0,,", "1,,,3,0,,", "1,,,4,0,,", "1,,,5,0,,"]);
    assert!(table(Panel::default()).is_empty());
}
