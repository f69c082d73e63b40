//! Tests of `src/spectrum` from inside. The second opinion is `nalgebra`'s: a real Schur form, which shares no code with ours.

use nalgebra::{Complex, Schur};

use super::*;
use crate::figure4;
use crate::lifted::driven::device_states;
use crate::lifted::pair::pair_matrix;
use crate::lifted::{Lifted, prune, rest};
use crate::oracle::rows;

fn radius(matrix: &mut Matrix) -> Option<f64> {
    Spectrum::default().polar(matrix).map(|polar| super::radius(&polar))
}

/// The largest |eigenvalue| by `nalgebra`, of the matrix or of a mirror image that it gets on with.
fn second(matrix: &Matrix) -> f64 {
    let mut balanced = matrix.clone();
    balance(&mut balanced, |_, _| {});
    let images = std::iter::once(balanced.clone()).chain(MIRRORS.iter().map(|step| mirrored(&balanced, *step)));
    let found = images.into_iter().find_map(|image| {
        let steps = 10 * image.nrows().max(10);
        Some(Schur::try_new(image, f64::EPSILON, steps)?.complex_eigenvalues())
    });
    found.expect("one of four converges").iter().map(|value: &Complex<f64>| value.norm()).fold(0.0, f64::max)
}

/// Blocks down the diagonal, seen through two mirrors: every entry filled, the eigenvalues those of the blocks.
fn hidden(blocks: &[Matrix]) -> Matrix {
    let size = blocks.iter().map(Matrix::nrows).sum();
    let mut matrix = Matrix::zeros(size, size);
    let mut at = 0;
    for block in blocks {
        matrix.view_mut((at, at), (block.nrows(), block.nrows())).copy_from(block);
        at += block.nrows();
    }
    mirrored(&mirrored(&matrix, MIRRORS[0]), MIRRORS[2])
}

/// An eigenvalue as often as the block has rows, with one eigenvector.
fn jordan(value: f64, size: usize) -> Matrix {
    Matrix::from_fn(size, size, |i, j| if i == j { value } else { f64::from(u8::from(i + 1 == j)) })
}

/// A pair of eigenvalues of this size at this angle.
fn pair(size: f64, angle: f64) -> Matrix {
    let (sin, cos) = angle.sin_cos();
    rows([[size * cos, -size * sin], [size * sin, size * cos]])
}

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
    assert_eq!(radius(&mut Matrix::zeros(5, 5)), Some(0.0));
    assert_eq!(radius(&mut rows([[-3.0]])), Some(3.0));
    let rotation = radius(&mut rows([[0.0, -2.0], [2.0, 0.0]])).unwrap();
    assert!((rotation - 2.0).abs() < 1e-15);
    assert_eq!(radius(&mut rows([[f64::NAN]])), Some(f64::INFINITY));
    assert_eq!(radius(&mut Matrix::identity(300, 300)), Some(1.0));
}

/// A ring of states, each passed on to the next: eigenvalues are the roots of 1, which ordinary shifts pass round for ever.
#[test]
fn a_ring_is_not_turned_for_ever() {
    for states in [3, 4, 5, 40] {
        let ring = Matrix::from_fn(states, states, |i, j| if (j + 1) % states == i { 1.0 } else { 0.0 });
        for seen in [ring.clone(), mirrored(&ring, MIRRORS[1])] {
            let mut spectrum = Spectrum::default();
            let found = spectrum.eigenvalues(&seen).unwrap();
            assert_eq!(found.len(), states);
            for k in 0..states {
                let (im, re) = (std::f64::consts::TAU * k as f64 / states as f64).sin_cos();
                let near = |(x, y): &(f64, f64)| (x - re).hypot(y - im) < 1e-13;
                assert_eq!(found.iter().filter(|value| near(value)).count(), 1, "{k} of {states}");
            }
        }
    }
}

/// Eigenvalues with fewer eigenvectors than they should have, beside one that decides by a hair's breadth: known radii.
#[test]
fn defective_eigenvalues_do_not_disturb_the_largest() {
    for block in 2..=6 {
        for wanted in [0.999_999, 1.0, 1.000_001] {
            let mut matrix = hidden(&[jordan(0.7, block), rows([[-wanted]]), jordan(-0.5, block), pair(0.9, 1.0)]);
            let other = second(&matrix);
            let found = radius(&mut matrix).unwrap();
            assert!((found - wanted).abs() < 1e-11 && (found - other).abs() < 1e-11, "{block}: {found} for {wanted}");
        }
    }
    // A double one is known to the root of rounding, by whatever method.
    let mut double = hidden(&[jordan(0.999, 2), pair(0.5, 2.0)]);
    assert!((radius(&mut double).unwrap() - 0.999).abs() < 1e-7);
}

/// Many eigenvalues within a millionth of the circle, and of each other.
#[test]
fn clusters_at_the_circle_are_told_apart() {
    let turns = |count: u32, difference: f64| -> Vec<Matrix> {
        (0..count).map(|at| pair(1.0 - 1e-6 * f64::from(at), 0.3 + difference * f64::from(at))).collect()
    };
    for blocks in [turns(12, 0.2), turns(8, 1e-6), (0..9).map(|at| rows([[1.0 - 1e-7 * f64::from(at)]])).collect()] {
        let mut matrix = hidden(&blocks);
        let other = second(&matrix);
        let found = radius(&mut matrix).unwrap();
        assert!((found - 1.0).abs() < 1e-12 && (found - other).abs() < 1e-12, "{found}, {other}");
    }
}

/// States that only wait, up to the longest delay: a loop of gain g behind n of them has |z| = g^(1/n) all round.
#[test]
fn long_delays_have_roots_all_round() {
    for (states, gain) in [(10, 0.5), (100, 0.9), (300, 0.5), (300, 1.000_1)] {
        let delay = Matrix::from_fn(states, states, |i, j| match (i, j) {
            (0, j) if j + 1 == states => gain,
            (i, j) if i == j + 1 => 1.0,
            _ => 0.0,
        });
        let wanted = gain.powf(1.0 / states as f64);
        for mut seen in [delay.clone(), mirrored(&delay, MIRRORS[1])] {
            let found = radius(&mut seen).unwrap();
            assert!((found - wanted).abs() < 1e-12, "{states} states: {found} for {wanted}");
        }
    }
}

/// What it is for: the figure's scenes from one packet on its way to a hundred.
#[test]
fn lifted_matrices_have_the_same_radius_by_another_method() {
    for law in figure4::COMMS {
        for delay in [0, 1, 3, 10, 30] {
            for (contact, coordination) in [(500.0, 1590.0), (1000.0, 5018.0), (2400.0, 10_700.0)] {
                let mut scene = figure4::scene(law, delay);
                scene.peer.contact.stiffness_n_per_m = contact;
                scene.peer.coordination.stiffness_n_per_m = coordination;
                let linear = scene.linear();
                let whole = pair_matrix(&linear).unwrap();
                let kept = prune::kept(&whole.matrix, &[device_states(&linear, 0)]);
                let mut lifted = Lifted::default();
                prune::copy(&whole, &kept, &mut lifted);
                rest::divide_out(&mut lifted);
                let other = second(&lifted.matrix);
                let found = radius(&mut lifted.matrix).unwrap();
                assert!((found - other).abs() < 1e-10 * other, "{law}, {delay} packets: {found}, {other}");
            }
        }
    }
}
