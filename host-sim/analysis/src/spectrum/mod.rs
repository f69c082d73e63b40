//! The spectral radius of a matrix.
//!
//! States come in metres, m/s and newtons, so entries spread over ten orders of magnitude: the matrix is balanced first
//! (Parlett & Reinsch 1969: a diagonal similarity by powers of two, hence without rounding), then its eigenvalues are found
//! ([`francis`]). Error: a few 1e-16 of the balanced norm, divided by the condition of the eigenvalue.
//!
//! Where the iteration should stand still, the matrix is mirrored, an orthogonal similarity that leaves no structure on which it
//! could, and tried again.

mod francis;

use francis::Francis;
use nalgebra::DVector;

use super::matrix::{Matrix, column_mut};

/// What the mirrors are made of, one for each further try: irrational, so that no two entries of one are alike.
const MIRRORS: [f64; 3] = [std::f64::consts::SQRT_2, std::f64::consts::E, std::f64::consts::PI];

/// Size and angle (rad, 0 to π) of every eigenvalue, the largest first; each of a pair counts.
pub(crate) type Polar = Vec<[f64; 2]>;

/// The largest |eigenvalue|, 0 of none.
pub(crate) fn radius(polar: &[[f64; 2]]) -> f64 {
    polar.first().map_or(0.0, |first| first[0])
}

/// Finds spectral radii, one after the other, in the same memory.
#[derive(Debug, Default)]
pub(crate) struct Spectrum {
    francis: Francis,
    worked: Matrix,
}

impl Spectrum {
    /// Every eigenvalue by size; one infinite where an entry is not finite, `None` where the iteration did not converge. The matrix is
    /// balanced in place.
    pub(crate) fn polar(&mut self, matrix: &mut Matrix) -> Option<Polar> {
        self.polar_beside(matrix, |_, _| false).map(|(polar, _)| polar)
    }

    /// [`Spectrum::polar`] without the eigenvalues (real, imaginary) that `leave` names, and how many these were.
    pub(crate) fn polar_beside(
        &mut self,
        matrix: &mut Matrix,
        leave: impl Fn(f64, f64) -> bool,
    ) -> Option<(Polar, usize)> {
        if !matrix.iter().all(|entry| entry.is_finite()) {
            return Some((vec![[f64::INFINITY, 0.0]], 0));
        }
        balance(matrix, |_, _| {});
        let all = self.eigenvalues(matrix)?;
        let kept = all.iter().filter(|(re, im)| !leave(*re, *im));
        let mut polar: Polar = kept.map(|(re, im)| [re.hypot(*im), im.abs().atan2(*re)]).collect();
        polar.sort_unstable_by(|a, b| b[0].total_cmp(&a[0]));
        let left = all.len() - polar.len();
        Some((polar, left))
    }

    /// All eigenvalues as (real, imaginary), in no order; `None` where the iteration did not converge.
    pub(crate) fn eigenvalues(&mut self, matrix: &Matrix) -> Option<&[(f64, f64)]> {
        let Self { francis, worked } = self;
        worked.clone_from(matrix);
        let mut mirrors = MIRRORS.iter();
        while !francis.iterate(worked) {
            *worked = mirrored(matrix, *mirrors.next()?);
        }
        Some(&francis.found)
    }
}

/// (1 − 2·n·nᵀ)·M·(1 − 2·n·nᵀ), where n has the direction of the fractions of multiples of `step`, less a half.
fn mirrored(matrix: &Matrix, step: f64) -> Matrix {
    let normal = DVector::from_fn(matrix.nrows(), |at, _| ((at + 1) as f64 * step).fract() - 0.5).normalize();
    let mirror = Matrix::identity(matrix.nrows(), matrix.nrows()) - &normal * normal.transpose() * 2.0;
    &mirror * matrix * &mirror
}

/// Scales rows and columns by powers of two until their sums are alike; eigenvalues stay as they are. `scaled` gets every
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
#[path = "../../tests/inside/spectrum.rs"]
mod tests;
