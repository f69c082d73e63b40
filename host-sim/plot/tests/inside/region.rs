//! Tests of `src/region.rs` from inside.

use super::*;

#[test]
fn borders_are_half_way_and_inside() {
    assert_eq!(edges(&[10.0, 20.0, 40.0], 0.0, 45.0), [5.0, 15.0, 30.0, 45.0]);
    assert_eq!(edges(&[40.0, 20.0], 0.0, 45.0), [45.0, 30.0, 10.0]);
    assert_eq!(edges(&[10.0], 0.0, 45.0), [0.0, 45.0]);
    assert_eq!(edges(&[f64::NAN, 10.0], 0.0, 45.0).len(), 3);
    assert!(edges(&[], 0.0, 45.0).is_empty());
}
