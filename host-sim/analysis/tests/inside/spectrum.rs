//! Tests of `src/spectrum.rs` from inside.

use super::*;
use crate::matrix::rows;

/// A companion matrix has the roots of its polynomial: (x − 2)(x² + 9).
#[test]
fn roots_of_a_known_polynomial() {
    let mut matrix = rows([[2.0, -9.0, 18.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert!((radius(&mut matrix).unwrap() - 3.0).abs() < 1e-14);
}

/// The same eigenvalues in newtons and micrometres.
#[test]
fn units_do_not_matter() {
    let mut matrix = rows([[2.0, -9.0, 18.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    for (at, unit) in [1e9, 1.0, 1e-7].into_iter().enumerate() {
        for other in 0..3 {
            matrix[(at, other)] *= unit;
            matrix[(other, at)] /= unit;
        }
    }
    assert!((radius(&mut matrix).unwrap() - 3.0).abs() < 1e-13);
}

#[test]
fn small_and_broken_matrices() {
    assert_eq!(radius(&mut Matrix::zeros(0, 0)), Some(0.0));
    assert_eq!(radius(&mut rows([[-3.0]])), Some(3.0));
    let rotation = radius(&mut rows([[0.0, -2.0], [2.0, 0.0]])).unwrap();
    assert!((rotation - 2.0).abs() < 1e-15);
    assert_eq!(radius(&mut rows([[f64::NAN]])), Some(f64::INFINITY));
    assert_eq!(radius(&mut Matrix::identity(300, 300)), Some(1.0));
}

/// A ring of states, each passed on to the next: eigenvalues are the roots of 1, and QR as it is turns for ever.
#[test]
fn a_ring_is_not_turned_for_ever() {
    for states in [3, 4, 5, 40] {
        let ring = Matrix::from_fn(states, states, |i, j| if (j + 1) % states == i { 1.0 } else { 0.0 });
        let found = eigenvalues(&ring).unwrap();
        assert_eq!(found.len(), states);
        for k in 0..states {
            let (im, re) = (std::f64::consts::TAU * k as f64 / states as f64).sin_cos();
            let near = |(x, y): &(f64, f64)| (x - re).hypot(y - im) < 1e-13;
            assert_eq!(found.iter().filter(|value| near(value)).count(), 1, "{k} of {states}");
        }
    }
}
