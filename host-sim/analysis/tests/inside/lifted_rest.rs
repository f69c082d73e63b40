//! Tests of `src/lifted/rest.rs` from inside.

use super::*;
use crate::oracle::rows;
use crate::spectrum::Spectrum;

/// S·diag·S⁻¹ for a basis S given by its columns.
fn with_eigenvectors(basis: &Matrix, values: &[f64]) -> Matrix {
    let scaled = Matrix::from_fn(basis.nrows(), values.len(), |i, j| basis[(i, j)] * values[j]);
    scaled * basis.clone().try_inverse().unwrap()
}

fn basis() -> Matrix {
    rows([
        [1.0, 0.0, 0.3, -0.2, 0.1],
        [1.0, 0.0, -0.5, 0.4, 0.0],
        [0.0, 2.0, 0.2, 0.1, -0.7],
        [0.0, 2.0, 0.0, -0.3, 0.6],
        [0.5, 0.0, 0.9, 0.8, 0.2],
    ])
}

#[test]
fn only_the_rest_modes_go() {
    // Three eigenvalues of 1 or nearly so; two of them are rest modes, the third is not.
    let values = [1.0, 1.0, 0.999_999_999, -0.4, 0.25];
    let matrix = with_eigenvectors(&basis(), &values);
    let modes = vec![column(&basis(), 0).to_vec(), column(&basis(), 1).to_vec()];
    let mut lifted = Lifted { matrix, rest_modes: modes };
    assert_eq!(divide_out(&mut lifted), 2);
    assert_eq!(lifted.matrix.nrows(), 3);
    let mut left: Vec<f64> =
        Spectrum::default().eigenvalues(&lifted.matrix).unwrap().iter().map(|(re, _)| *re).collect();
    left.sort_by(f64::total_cmp);
    for (got, wanted) in left.iter().zip([-0.4, 0.25, 0.999_999_999]) {
        assert!((got - wanted).abs() < 1e-13, "{got} {wanted}");
    }
}

#[test]
fn dependent_modes_count_once() {
    let matrix = with_eigenvectors(&basis(), &[1.0, 1.0, 0.5, 0.5, 0.5]);
    let (first, second) = (column(&basis(), 0).to_vec(), column(&basis(), 1).to_vec());
    let sum = first.iter().zip(&second).map(|(a, b)| a - 3.0 * b).collect();
    let mut lifted = Lifted { matrix, rest_modes: vec![first, sum, second] };
    assert_eq!(divide_out(&mut lifted), 2);
    assert!((Spectrum::default().polar(&mut lifted.matrix).unwrap()[0][0] - 0.5).abs() < 1e-13);
}

#[test]
fn an_unstable_eigenvalue_survives() {
    let matrix = with_eigenvectors(&basis(), &[1.0, 1.5, 0.5, 0.5, 0.5]);
    let mut lifted = Lifted { matrix, rest_modes: vec![column(&basis(), 0).to_vec()] };
    assert_eq!(divide_out(&mut lifted), 1);
    assert!((Spectrum::default().polar(&mut lifted.matrix).unwrap()[0][0] - 1.5).abs() < 1e-13);
}

#[test]
fn idle_coordinates_are_found_once() {
    let mut lifted = Lifted {
        matrix: rows([[1.0, 0.5, 0.0], [0.0, 0.5, 0.0], [0.0, 0.1, 1.0]]),
        rest_modes: vec![vec![2.0, 0.0, 0.0]],
    };
    idle(&mut lifted);
    assert_eq!(lifted.rest_modes.len(), 2);
    assert_eq!(divide_out(&mut lifted), 2);
    assert_eq!(lifted.matrix, rows([[0.5]]));
}
