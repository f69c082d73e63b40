//! The matrix exponential, by its diagonal Padé approximant.
//!
//! e^X ≈ q(X/2ˢ)⁻¹·p(X/2ˢ), squared s times, of order (6, 6) with ‖X‖ ≤ ½ after scaling: relative error below 1e-16
//! (Golub & Van Loan, §9.3).

use crate::matrix::Matrix;

/// The matrix exponential e^X of `matrix`.
pub fn exponential(matrix: &Matrix) -> Matrix {
    let size = matrix.nrows();
    let norm = matrix.column_iter().map(|column| column.iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
    let halvings = if norm > 0.5 { norm.log2().ceil() as i32 + 1 } else { 0 };
    let scaled = matrix * 0.5_f64.powi(halvings);
    let (mut above, mut below) = (Matrix::identity(size, size), Matrix::identity(size, size));
    let mut power = Matrix::identity(size, size);
    let mut weight = 1.0;
    for k in 1..=6 {
        let order = f64::from(k);
        weight *= (7.0 - order) / (order * (13.0 - order));
        power = &scaled * &power;
        above += &power * weight;
        below += &power * if k % 2 == 0 { weight } else { -weight };
    }
    below.lu().solve_mut(&mut above);
    for _ in 0..halvings {
        above = &above * &above;
    }
    above
}

#[cfg(test)]
#[path = "../tests/inside/exponential.rs"]
mod tests;
