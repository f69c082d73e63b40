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

#[test]
fn borders_are_half_way_and_inside() {
    assert_eq!(edges(&[10.0, 20.0, 40.0], 0.0, 45.0), [5.0, 15.0, 30.0, 45.0]);
    assert_eq!(edges(&[40.0, 20.0], 0.0, 45.0), [45.0, 30.0, 10.0]);
    assert_eq!(edges(&[10.0], 0.0, 45.0), [0.0, 45.0]);
    assert_eq!(edges(&[f64::NAN, 10.0], 0.0, 45.0).len(), 3);
    assert!(edges(&[], 0.0, 45.0).is_empty());
}
