//! Eigenvalues of a matrix, by `nalgebra`.
//!
//! States come in metres, m/s and newtons, so entries spread over ten orders of magnitude: the matrix is balanced first
//! (Parlett & Reinsch 1969: a diagonal similarity by powers of two, hence without rounding), then reduced to Hessenberg
//! form and iterated by QR. Error: a few 1e-16 of the balanced norm, divided by the condition of the eigenvalue.
//!
//! The iteration of `nalgebra` 0.35 has no exceptional shifts and starts every sweep at the first row: it stands still on a matrix
//! that only passes its states round in a ring, and on some with many packets on their way, where the shift is lost before it
//! arrives at the last rows (Watkins 1996). Where it gives up, the matrix is mirrored, an orthogonal similarity that
//! leaves no such structure, and tried again.

use nalgebra::{DVector, Schur};

use super::matrix::{Matrix, column_mut};

/// Most steps of the iteration, for each row of the matrix, and for matrices of few rows as for this many: two or three are usual.
const STEPS_PER_ROW: usize = 10;
const FEW_ROWS: usize = 10;

/// What the mirrors are made of, one for each further try: irrational, so that no two entries of one are alike.
const MIRRORS: [f64; 3] = [std::f64::consts::SQRT_2, std::f64::consts::E, std::f64::consts::PI];

/// Largest |eigenvalue|; infinite where an entry is not finite, `None` where the iteration did not converge.
/// The matrix is balanced in place.
pub(crate) fn radius(matrix: &mut Matrix) -> Option<f64> {
    radius_beside(matrix, |_, _| false).map(|(radius, _)| radius)
}

/// The same with the eigenvalues (real, imaginary) that `leave` names left out, and how many these were.
pub(crate) fn radius_beside(matrix: &mut Matrix, leave: impl Fn(f64, f64) -> bool) -> Option<(f64, usize)> {
    if !matrix.iter().all(|entry| entry.is_finite()) {
        return Some((f64::INFINITY, 0));
    }
    balance(matrix, |_, _| {});
    let left = |(largest, left): (f64, usize), (re, im): (f64, f64)| {
        if leave(re, im) { (largest, left + 1) } else { (largest.max(re.hypot(im)), left) }
    };
    eigenvalues(matrix).map(|all| all.into_iter().fold((0.0, 0), left))
}

/// All eigenvalues as (real, imaginary), in no order; `None` where the iteration did not converge.
pub(crate) fn eigenvalues(matrix: &Matrix) -> Option<Vec<(f64, f64)>> {
    if matrix.is_empty() {
        return Some(Vec::new());
    }
    iterate(matrix.clone()).or_else(|| MIRRORS.iter().find_map(|step| iterate(mirrored(matrix, *step))))
}

fn iterate(matrix: Matrix) -> Option<Vec<(f64, f64)>> {
    let steps = STEPS_PER_ROW * matrix.nrows().max(FEW_ROWS);
    let found = Schur::try_new(matrix, f64::EPSILON, steps)?.complex_eigenvalues();
    let finite = found.iter().all(|value| value.re.is_finite() && value.im.is_finite());
    finite.then(|| found.iter().map(|value| (value.re, value.im)).collect())
}

/// (1 − 2·n·nᵀ)·M·(1 − 2·n·nᵀ), where n has the direction of the fractions of multiples of `step`, less a half.
fn mirrored(matrix: &Matrix, step: f64) -> Matrix {
    let normal = DVector::from_fn(matrix.nrows(), |at, _| ((at + 1) as f64 * step).fract() - 0.5).normalize();
    let mirror = Matrix::identity(matrix.nrows(), matrix.nrows()) - &normal * normal.transpose() * 2.0;
    &mirror * matrix * &mirror
}

/// Scales rows and columns by powers of two until their sums are alike; eigenvalues stay as they are. `scaled` is told every
/// state and the factor by which its unit grew.
pub(crate) fn balance(matrix: &mut Matrix, mut scaled: impl FnMut(usize, f64)) {
    let size = matrix.nrows();
    // Each sweep that changes anything lowers the norm by a fifth somewhere: a dozen are plenty.
    for _ in 0..12 {
        let mut settled = true;
        for at in 0..size {
            let (mut row, mut column) = (0.0, 0.0);
            for other in (0..size).filter(|other| *other != at) {
                row += matrix[(at, other)].abs();
                column += matrix[(other, at)].abs();
            }
            if row == 0.0 || column == 0.0 {
                continue;
            }
            let factor = root_power(row / column);
            if column * factor + row / factor < 0.8 * (column + row) {
                settled = false;
                scaled(at, factor);
                for entry in column_mut(matrix, at) {
                    *entry *= factor;
                }
                for other in 0..size {
                    matrix[(at, other)] /= factor;
                }
            }
        }
        if settled {
            break;
        }
    }
}

/// A power of two near the square root of a positive number, from its exponent; held within 2^±500.
fn root_power(value: f64) -> f64 {
    let exponent = (value.to_bits() >> 52) as i64 - 1023;
    let half = exponent.div_euclid(2).clamp(-500, 500);
    f64::from_bits(((1023 + half) as u64) << 52)
}

#[cfg(test)]
#[path = "../tests/inside/spectrum.rs"]
mod tests;
