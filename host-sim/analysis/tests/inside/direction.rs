//! Directions of matrices whose eigenvectors are known.

use super::{Direction, direction};
use crate::matrix::Matrix;
use crate::oracle::rows;

/// An object's position and velocity along two axes that are turned by `angle`: decay 0.5 and 0.9 along the turned axes, velocities 0.1.
fn turned(angle: f64) -> Matrix {
    let (s, c) = angle.sin_cos();
    let (slow, fast) = (0.9, 0.5);
    rows([
        [c * c * slow + s * s * fast, c * s * (slow - fast), 1e-3, 0.0],
        [c * s * (slow - fast), s * s * slow + c * c * fast, 0.0, 1e-3],
        [0.0, 0.0, 0.1, 0.0],
        [0.0, 0.0, 0.0, 0.1],
    ])
}

#[test]
fn one_direction_is_found_wherever_it_points() {
    for angle in [0.0, 0.3, 0.7, 1.2] {
        let found = direction(&turned(angle), [0.9, 0.0], &[0, 1], 2);
        let Some(Direction::Along([x, y, z])) = found else { panic!("{angle}: {found:?}") };
        assert!((x - angle.cos()).abs() < 1e-6 && (y - angle.sin()).abs() < 1e-6 && z == 0.0, "{angle}: {found:?}");
    }
}

#[test]
fn axes_that_share_an_eigenvalue_leave_the_direction_open() {
    let alike = rows([[0.9, 0.0], [0.0, 0.9]]);
    assert_eq!(direction(&alike, [0.9, 0.0], &[0, 1], 2), Some(Direction::Any));
    let plane = rows([[0.9, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.9]]);
    assert_eq!(direction(&plane, [0.9, 0.0], &[0, 1, 2], 3), Some(Direction::Across([0.0, 1.0, 0.0])));
    assert_eq!(direction(&plane, [0.5, 0.0], &[0, 1, 2], 3), Some(Direction::Along([0.0, 1.0, 0.0])));
    let infinite = rows([[f64::INFINITY, 0.0], [0.0, 0.9]]);
    assert_eq!(direction(&infinite, [f64::INFINITY, 0.0], &[0, 1], 2), None);
}
