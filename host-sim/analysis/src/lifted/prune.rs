//! Leaves out states that cannot matter, so that `states` is honest and the eigenproblem small.
//!
//! Dropped, one after the other until nothing changes: a state that nothing after the period depends on (its column is
//! zero: what an exchange overwrites), and one that is always zero (its row is zero: a packet's unused field). Either way
//! the matrix has a block-triangular form in which the state stands alone with eigenvalue 0. Then whatever is not coupled
//! to an object at all, in either direction: a second axis that the scene does not use, a device that nobody holds the object
//! with.
//!
//! Zeros are exact zeros: a product with 0, not a small number.

use super::Lifted;
use crate::matrix::{Matrix, column, column_mut, reset};

/// Remembers what was worth keeping: along a sweep the zeros stay where they are.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pruner {
    filled: Vec<bool>,
    anchors: Vec<usize>,
    kept: Vec<usize>,
}

impl Pruner {
    /// What [`kept`] says, found again only where an entry became or ceased to be zero.
    pub(crate) fn kept(&mut self, matrix: &Matrix, anchors: &[usize]) -> &[usize] {
        let filled = || matrix.iter().map(|entry| *entry != 0.0);
        if self.anchors != anchors || !filled().eq(self.filled.iter().copied()) {
            self.filled.clear();
            self.filled.extend(filled());
            self.anchors = anchors.to_vec();
            self.kept = kept(matrix, anchors);
        }
        &self.kept
    }
}

/// The states worth keeping, ascending. `anchors` are states known to matter, one for each object.
pub(crate) fn kept(matrix: &Matrix, anchors: &[usize]) -> Vec<usize> {
    let size = matrix.nrows();
    let (mut in_row, mut in_column) = (vec![0_usize; size], vec![0_usize; size]);
    for (j, filled) in in_column.iter_mut().enumerate() {
        for (i, _) in column(matrix, j).iter().enumerate().filter(|(_, entry)| **entry != 0.0) {
            in_row[i] += 1;
            *filled += 1;
        }
    }
    let mut alive = vec![true; size];
    let mut doomed: Vec<usize> = (0..size).filter(|at| in_row[*at] == 0 || in_column[*at] == 0).collect();
    while let Some(at) = doomed.pop() {
        if !std::mem::replace(&mut alive[at], false) {
            continue;
        }
        for other in 0..size {
            if matrix[(other, at)] != 0.0 {
                in_row[other] -= 1;
            }
            if matrix[(at, other)] != 0.0 {
                in_column[other] -= 1;
            }
            if alive[other] && (in_row[other] == 0 || in_column[other] == 0) {
                doomed.push(other);
            }
        }
    }
    let mut reached = vec![false; size];
    let mut next: Vec<usize> = anchors.iter().copied().filter(|at| alive[*at]).collect();
    while let Some(at) = next.pop() {
        if std::mem::replace(&mut reached[at], true) {
            continue;
        }
        let coupled = |other: &usize| matrix[(*other, at)] != 0.0 || matrix[(at, *other)] != 0.0;
        next.extend((0..size).filter(|other| alive[*other] && !reached[*other]).filter(coupled));
    }
    (0..size).filter(|at| reached[*at]).collect()
}

/// Copies what is kept of `from` into `to`.
pub(crate) fn copy(from: &Lifted, kept: &[usize], to: &mut Lifted) {
    reset(&mut to.matrix, kept.len(), kept.len());
    for (to_column, j) in kept.iter().enumerate() {
        let source = column(&from.matrix, *j);
        for (out, i) in column_mut(&mut to.matrix, to_column).iter_mut().zip(kept) {
            *out = source[*i];
        }
    }
    to.rest_modes.clear();
    to.rest_modes.extend(from.rest_modes.iter().map(|mode| kept.iter().map(|at| mode[*at]).collect()));
}

#[cfg(test)]
#[path = "../../tests/inside/lifted_prune.rs"]
mod tests;
