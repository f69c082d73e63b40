//! Of a matrix whose exponential is known.

use super::exponential;
use crate::oracle::rows;

#[test]
fn a_rotation_is_a_rotation() {
    for angle in [1e-9_f64, 0.3, 2.0, 40.0] {
        let turned = exponential(&rows([[0.0, -angle], [angle, 0.0]]));
        assert!((turned[(0, 0)] - angle.cos()).abs() < 1e-14 * (1.0 + angle));
        assert!((turned[(1, 0)] - angle.sin()).abs() < 1e-14 * (1.0 + angle));
    }
}
