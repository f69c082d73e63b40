//! Along which direction of the task the objects move in the mode that decides, where they are shared along several axes.
//!
//! The eigenvector of the eigenvalue that is known is found by inverse iteration, once from the object along every axis: where axes have
//! that eigenvalue in common each start ends at another vector of theirs, and all of them together span what the mode leaves open. What
//! the vectors say of the objects' positions is one symmetric matrix; its largest eigenvectors are the directions.

use std::fmt;

use nalgebra::{Complex, DMatrix, DVector, Matrix3, SymmetricEigen};
use serde::Serialize;

use crate::matrix::Matrix;
use crate::spectrum::balance;

/// How far beside the eigenvalue the iteration is shifted, relative: far more than rounding, far less than eigenvalues are apart.
const BESIDE: f64 = 1e-9;

/// Solves of an iteration.
const SOLVES: usize = 3;

/// Share of the largest below which a direction takes no part.
const NO_PART: f64 = 1e-3;

/// Where the objects move in a mode.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// To and fro along this unit vector; of two axes the third part is 0.
    Along([f64; 3]),
    /// Any way across this unit vector, in space.
    Across([f64; 3]),
    /// No direction is preferred.
    Any,
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (word, [x, y, z]) = match self {
            Self::Along(unit) => ("along", *unit),
            Self::Across(unit) => ("across", *unit),
            Self::Any => return f.write_str("any"),
        };
        write!(f, "{word} {x:.3} {y:.3} {z:.3}")
    }
}

/// The direction of the eigenvalue of this size and angle (rad) of a matrix in which `objects` are the positions of one object or two
/// along `axes` axes, one object after the other. None where it cannot be determined.
pub(crate) fn direction(matrix: &Matrix, [size, angle]: [f64; 2], objects: &[usize], axes: usize) -> Option<Direction> {
    if !size.is_finite() || !matrix.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let (mut balanced, mut units) = (matrix.clone(), vec![1.0; matrix.nrows()]);
    balance(&mut balanced, |at, factor| units[at] *= factor);
    let shift = Complex::from_polar(size * (1.0 + BESIDE), angle);
    let shifted = DMatrix::from_fn(balanced.nrows(), balanced.nrows(), |row, column| {
        Complex::from(balanced[(row, column)]) - if row == column { shift } else { Complex::from(0.0) }
    });
    let factors = shifted.lu();
    let mut found = Vec::with_capacity(axes);
    for start in &objects[..axes] {
        let mut vector = DVector::from_element(balanced.nrows(), Complex::from(0.0));
        vector[*start] = Complex::from(1.0);
        let mut grown = 0.0_f64;
        for _ in 0..SOLVES {
            vector = factors.solve(&vector)?;
            grown = vector.norm();
            vector /= Complex::from(grown);
        }
        found.push((grown, vector));
    }
    // A start that has no part in the mode does not grow as one that has.
    let most = found.iter().map(|(grown, _)| *grown).fold(0.0, f64::max);
    let mut seen = Matrix3::<f64>::zeros();
    for (_, vector) in found.iter().filter(|(grown, _)| *grown > NO_PART * most) {
        let moved = |at: usize| vector[at] * units[at];
        let scale = objects.iter().map(|at| moved(*at).norm_sqr()).sum::<f64>();
        for object in objects.chunks(axes).filter(|_| scale > 0.0) {
            let part = |axis: usize| object.get(axis).map_or(Complex::from(0.0), |at| moved(*at));
            seen += Matrix3::from_fn(|row, column| (part(row) * part(column).conj()).re / scale);
        }
    }
    principal_directions(seen, axes)
}

/// The directions whose share counts.
fn principal_directions(seen: Matrix3<f64>, axes: usize) -> Option<Direction> {
    let eigen = SymmetricEigen::new(seen);
    let most = eigen.eigenvalues.max();
    if most == 0.0 {
        return None;
    }
    let takes_part = |at: &usize| eigen.eigenvalues[*at] > NO_PART * most;
    let unit = |at: usize| {
        let vector = eigen.eigenvectors.column(at);
        // Of the two ways the one whose largest part is positive.
        let largest = vector[vector.iamax()];
        [0, 1, 2].map(|axis| vector[axis] * largest.signum() + 0.0)
    };
    let part: Vec<usize> = (0..3).filter(takes_part).collect();
    match (part.as_slice(), axes) {
        ([one], _) => Some(Direction::Along(unit(*one))),
        ([_, _], 3) => (0..3).find(|at| !takes_part(at)).map(|normal| Direction::Across(unit(normal))),
        _ => Some(Direction::Any),
    }
}

#[cfg(test)]
#[path = "../tests/inside/direction.rs"]
mod tests;
