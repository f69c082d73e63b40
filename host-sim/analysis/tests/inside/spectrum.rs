//! Tests of `src/spectrum.rs` from inside.

use faer::mat;

use super::*;

/// A companion matrix has the roots of its polynomial: (x − 2)(x² + 9).
#[test]
fn roots_of_a_known_polynomial() {
    let mut matrix = mat![[2.0, -9.0, 18.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    assert!((Spectrum::default().radius(&mut matrix).unwrap() - 3.0).abs() < 1e-14);
}

/// The same eigenvalues in newtons and micrometres.
#[test]
fn units_do_not_matter() {
    let mut matrix = mat![[2.0, -9.0, 18.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    for (at, unit) in [1e9, 1.0, 1e-7].into_iter().enumerate() {
        for other in 0..3 {
            matrix[(at, other)] *= unit;
            matrix[(other, at)] /= unit;
        }
    }
    assert!((Spectrum::default().radius(&mut matrix).unwrap() - 3.0).abs() < 1e-13);
}

#[test]
fn small_and_broken_matrices() {
    let mut spectrum = Spectrum::default();
    assert_eq!(spectrum.radius(&mut Matrix::zeros(0, 0)), Some(0.0));
    assert_eq!(spectrum.radius(&mut mat![[-3.0]]), Some(3.0));
    let rotation = spectrum.radius(&mut mat![[0.0, -2.0], [2.0, 0.0]]).unwrap();
    assert!((rotation - 2.0).abs() < 1e-15);
    assert_eq!(spectrum.radius(&mut mat![[f64::NAN]]), Some(f64::INFINITY));
    assert_eq!(spectrum.radius(&mut Matrix::identity(300, 300)), Some(1.0));
}
