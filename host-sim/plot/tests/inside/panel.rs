//! Tests of `src/panel.rs` from inside.

use super::*;

#[test]
fn a_run_that_diverges_ends_where_it_leaves() {
    let frame = Frame { left: 0.0, top: 0.0, right: 100.0, bottom: 10.0 };
    let heights = [-90.0, 5.0, -4.0, 12.0, 25.0, 5.0];
    let pixels: Vec<Point> = heights.iter().enumerate().map(|(i, y)| (i as f64, *y)).collect();
    assert_eq!(until_far(pixels.clone(), &frame), pixels[..5]);
    assert_eq!(until_far(pixels[..4].to_vec(), &frame), pixels[..4]);
}

#[test]
fn a_lattice_leaves_no_hole_for_a_box() {
    let area = Frame { left: 0.0, top: 0.0, right: 100.0, bottom: 3.0 };
    let points = lattice(&area);
    for left in 0..80 {
        let other = Frame { left: f64::from(left), top: 0.0, right: f64::from(left) + 13.0, bottom: 13.0 };
        assert!(points.iter().any(|p| other.contains(*p)), "{left}");
    }
}

#[test]
fn values_carry_no_zeros_that_say_nothing() {
    let cases = [(3.5, "3.5"), (0.099, "0.099"), (10620.0, "10620"), (-2.0, "−2"), (f64::NAN, "NaN"), (0.0, "0")];
    for (value, text) in cases {
        assert_eq!(value_text(value), text);
    }
}

/// A stroke from end to end with two cross-strokes and a dot; only the dot where the interval is nothing.
#[test]
fn an_interval_is_drawn_to_its_ends() {
    let series = vec![Series::intervals("", 0, vec![(0.0, 3.0, 2.0), (1.0, 4.0, 0.0)])];
    let panel = Panel { categories: vec!["a".to_owned(), "b".to_owned()], series, ..Panel::default() };
    let axes = crate::range::resolve(&crate::Figure { panels: vec![panel.clone()], ..Default::default() })[0];
    assert!(axes.y.lo < 1.0 && axes.y.hi > 5.0, "{axes:?}");
    let frame = Frame { left: 0.0, top: 0.0, right: 100.0, bottom: 100.0 };
    let marks = draw(&panel, &axes, &frame, &[], &[]).marks;
    let at = |y: f64| 100.0 - 100.0 * axes.y.fraction(y);
    let ends = |mark: &Mark| match mark {
        Mark::Line { points, width, .. } if *width == STROKE => Some(points.iter().map(|p| p.1).collect::<Vec<_>>()),
        _ => None,
    };
    let strokes: Vec<Vec<f64>> = marks.iter().filter_map(ends).collect();
    assert_eq!(strokes, [[at(1.0), at(5.0)], [at(1.0); 2], [at(5.0); 2]]);
    let discs = marks.iter().filter_map(|mark| if let Mark::Disc { at, .. } = mark { Some(at.1) } else { None });
    assert_eq!(discs.collect::<Vec<_>>(), [at(3.0), at(4.0)]);
}

/// A ring is hollow: what lies behind it is covered by the sheet's colour, and a legend shows it as it is drawn.
#[test]
fn a_ring_is_hollow() {
    let panel = Panel { series: vec![Series::rings("let go", 0, vec![(0.0, 1.0), (1.0, 2.0)])], ..Panel::default() };
    let axes = crate::range::resolve(&crate::Figure { panels: vec![panel.clone()], ..Default::default() })[0];
    assert!(axes.x.lo < 0.0 && axes.x.hi > 1.0, "{axes:?}");
    let frame = Frame { left: 0.0, top: 0.0, right: 100.0, bottom: 100.0 };
    let discs = |marks: Vec<Mark>| -> Vec<(Rgb, f64)> {
        let disc = |mark| if let Mark::Disc { radius, color, .. } = mark { Some((color, radius)) } else { None };
        marks.into_iter().filter_map(disc).collect()
    };
    let ring = [(color(0), DOT), (PAPER, DOT - STROKE)];
    assert_eq!(discs(draw(&panel, &axes, &frame, &[], &[]).marks), [ring, ring].concat());
    assert_eq!(discs(crate::legend::marks(&panel, &frame, frame)), ring);
}
