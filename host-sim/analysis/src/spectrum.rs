//! The largest |eigenvalue| of a matrix, by `faer`, on one core and without asking for memory twice.
//!
//! States come in metres, m/s and newtons, so entries spread over ten orders of magnitude: the matrix is balanced first
//! (Parlett & Reinsch 1969: a diagonal similarity by powers of two, hence without rounding), then reduced to Hessenberg
//! form and iterated by QR. Error: a few 1e-16 of the balanced norm, divided by the condition of the eigenvalue.
//!
//! `faer` 0.24 does not report a QR iteration that gives up; here the places for eigenvalues start as NaN, so that one
//! that was never written is seen, and the transposed matrix is tried before giving up.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, evd_real, evd_scratch};
use faer::{MatRef, Par, Spec};

use super::matrix::Matrix;

/// Workspace for matrices of any size; the last size is kept.
pub(crate) struct Spectrum {
    size: usize,
    real: Diag<f64>,
    imaginary: Diag<f64>,
    memory: MemBuffer,
}

impl std::fmt::Debug for Spectrum {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Spectrum").field("size", &self.size).finish_non_exhaustive()
    }
}

impl Default for Spectrum {
    fn default() -> Self {
        let memory = MemBuffer::new(faer::dyn_stack::StackReq::EMPTY);
        Self { size: 0, real: Diag::zeros(0), imaginary: Diag::zeros(0), memory }
    }
}

impl Spectrum {
    /// Largest |eigenvalue|; infinite where an entry is not finite, `None` where the iteration did not converge.
    /// The matrix is balanced in place.
    pub(crate) fn radius(&mut self, matrix: &mut Matrix) -> Option<f64> {
        self.radius_beside(matrix, |_, _| false).map(|(radius, _)| radius)
    }

    /// The same with the eigenvalues (real, imaginary) that `leave` names left out, and how many these were.
    pub(crate) fn radius_beside(
        &mut self,
        matrix: &mut Matrix,
        leave: impl Fn(f64, f64) -> bool,
    ) -> Option<(f64, usize)> {
        if !matrix.is_all_finite() {
            return Some((f64::INFINITY, 0));
        }
        balance(matrix, |_, _| {});
        let left = |(largest, left): (f64, usize), (re, im): (f64, f64)| {
            if leave(re, im) { (largest, left + 1) } else { (largest.max(re.hypot(im)), left) }
        };
        self.eigenvalues(matrix).map(|all| all.fold((0.0, 0), left))
    }

    /// All eigenvalues as (real, imaginary), in no order; `None` where the iteration did not converge.
    pub(crate) fn eigenvalues(&mut self, matrix: &Matrix) -> Option<impl Iterator<Item = (f64, f64)>> {
        let size = matrix.nrows();
        if size != self.size {
            let none = ComputeEigenvectors::No;
            // faer asks for the size of the matrix without its first row: nothing smaller than 2.
            self.memory = MemBuffer::new(evd_scratch::<f64>(size.max(2), none, none, Par::Seq, Spec::default()));
            (self.real, self.imaginary) = (Diag::zeros(size), Diag::zeros(size));
            self.size = size;
        }
        if size == 1 {
            (self.real[0], self.imaginary[0]) = (matrix[(0, 0)], 0.0);
        } else if size > 1 && !self.iterate(matrix.as_ref()) && !self.iterate(matrix.transpose()) {
            return None;
        }
        let (real, imaginary) = (&self.real, &self.imaginary);
        Some((0..size).map(move |at| (real[at], imaginary[at])))
    }

    fn iterate(&mut self, matrix: MatRef<'_, f64>) -> bool {
        self.real.column_vector_mut().fill(f64::NAN);
        let (real, imaginary) = (self.real.as_mut(), self.imaginary.as_mut());
        let stack = MemStack::new(&mut self.memory);
        evd_real(matrix, real, imaginary, None, None, Par::Seq, stack, Spec::default()).is_ok()
            && (0..self.size).all(|at| self.real[at].is_finite())
    }
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
                for entry in matrix.col_as_slice_mut(at) {
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
