//! Divides rest modes out of a lifted matrix by their eigenvectors.
//!
//! A rest mode v stays as it is: M·v = v. On the quotient by span(v) the matrix keeps all its other eigenvalues: with p the
//! largest component of v, M′ᵢⱼ = Mᵢⱼ − (vᵢ/v_p)·M_pj, without row and column p. No eigenvalue is looked at, so one that
//! happens to lie near 1 is never taken for a rest mode.
//!
//! Which vectors rest is known beforehand (THEORY §3): translations, tested by driving the peer there
//! ([`super::driven`]), and single coordinates that nothing depends on but themselves ([`idle`]).

use super::Lifted;
use crate::matrix::{Matrix, column, column_mut};

/// Adds to the rest modes every coordinate whose column is exactly its unit vector: where it stands is felt by nothing.
/// A device in a scene without contact and arm is the example.
pub(crate) fn idle(lifted: &mut Lifted) {
    let size = lifted.matrix.nrows();
    for at in 0..size {
        let column = column(&lifted.matrix, at);
        let alone = column.iter().enumerate().all(|(i, entry)| *entry == f64::from(u8::from(i == at)));
        // A translation of only this coordinate is already known.
        let known = |mode: &Vec<f64>| mode.iter().enumerate().all(|(i, entry)| (*entry != 0.0) == (i == at));
        if alone && !lifted.rest_modes.iter().any(known) {
            let mut mode = vec![0.0; size];
            mode[at] = 1.0;
            lifted.rest_modes.push(mode);
        }
    }
}

/// Divides all rest modes out, one after the other, and gives how many there were. A mode that the others already contain
/// is skipped.
pub(crate) fn divide_out(lifted: &mut Lifted) -> usize {
    let mut count = 0;
    while let Some(mode) = lifted.rest_modes.pop() {
        let largest = mode.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let Some((pivot, &head)) = largest.filter(|(_, head)| head.abs() > 1e-9) else { continue };
        count += 1;
        let size = lifted.matrix.nrows();
        let mut quotient = Matrix::zeros(size - 1, size - 1);
        for (to, j) in (0..size).filter(|j| *j != pivot).enumerate() {
            let source = column(&lifted.matrix, j);
            let share = source[pivot] / head;
            let rows = (0..size).filter(|i| *i != pivot);
            for (out, i) in column_mut(&mut quotient, to).iter_mut().zip(rows) {
                *out = source[i] - mode[i] * share;
            }
        }
        lifted.matrix = quotient;
        for other in &mut lifted.rest_modes {
            let share = other[pivot] / head;
            for (entry, taken) in other.iter_mut().zip(&mode) {
                *entry -= share * taken;
            }
            other.remove(pivot);
        }
    }
    count
}

#[cfg(test)]
#[path = "../../tests/inside/lifted_rest.rs"]
mod tests;
