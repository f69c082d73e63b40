//! A dense matrix, column by column, that can be filled again without asking for memory.
//!
//! Small on purpose: what the analysis needs of linear algebra and `faer` is not asked for. Units are those of the states
//! that rows and columns stand for.

use std::ops::{Index, IndexMut};

/// Rows × columns of `f64`, stored column by column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Matrix {
    rows: usize,
    columns: usize,
    entries: Vec<f64>,
}

impl Matrix {
    /// All zeros.
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self { rows, columns, entries: vec![0.0; rows * columns] }
    }

    /// Ones on the diagonal.
    pub fn identity(size: usize) -> Self {
        let mut identity = Self::zeros(size, size);
        for at in 0..size {
            identity[(at, at)] = 1.0;
        }
        identity
    }

    /// The matrix with these rows; a row that is too short is filled up with zeros.
    pub fn from_rows<const N: usize>(rows: &[[f64; N]]) -> Self {
        let mut matrix = Self::zeros(rows.len(), N);
        for (i, row) in rows.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                matrix[(i, j)] = *value;
            }
        }
        matrix
    }

    /// All zeros in another shape, in the memory that is there.
    pub fn reset(&mut self, rows: usize, columns: usize) {
        self.entries.clear();
        self.entries.resize(rows * columns, 0.0);
        (self.rows, self.columns) = (rows, columns);
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// All entries, column by column.
    pub fn entries(&self) -> &[f64] {
        &self.entries
    }

    /// One column.
    pub fn column(&self, at: usize) -> &[f64] {
        &self.entries[at * self.rows..(at + 1) * self.rows]
    }

    /// One column, to be written.
    pub fn column_mut(&mut self, at: usize) -> &mut [f64] {
        &mut self.entries[at * self.rows..(at + 1) * self.rows]
    }

    /// Every entry finite.
    pub fn is_finite(&self) -> bool {
        self.entries.iter().all(|entry| entry.is_finite())
    }

    /// This matrix times a vector.
    pub fn apply(&self, vector: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; self.rows];
        for (j, factor) in vector.iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
            for (out, entry) in product.iter_mut().zip(self.column(j)) {
                *out += entry * factor;
            }
        }
        product
    }

    /// This matrix times another.
    pub fn times(&self, other: &Self) -> Self {
        let mut product = Self::zeros(self.rows, other.columns);
        for j in 0..other.columns {
            let column = self.apply(other.column(j));
            product.column_mut(j).copy_from_slice(&column);
        }
        product
    }

    /// Adds `factor` times `block` with its corner at (`row`, `column`).
    pub fn add_block(&mut self, row: usize, column: usize, block: &Self, factor: f64) {
        for j in 0..block.columns {
            let target = &mut self.column_mut(column + j)[row..row + block.rows];
            for (out, entry) in target.iter_mut().zip(block.column(j)) {
                *out += factor * entry;
            }
        }
    }

    /// Solves `self · x = right` for every column of `right`, in place, by elimination with row exchange; `self` is used up.
    /// A singular matrix gives entries that are not finite.
    pub fn solve_into(mut self, right: &mut Self) {
        let size = self.rows;
        for step in 0..size {
            let pivot = (step..size).max_by(|&a, &b| self[(a, step)].abs().total_cmp(&self[(b, step)].abs()));
            let pivot = pivot.unwrap_or(step);
            if pivot != step {
                self.swap_rows(step, pivot);
                right.swap_rows(step, pivot);
            }
            let factors: Vec<f64> = (step + 1..size).map(|i| self[(i, step)] / self[(step, step)]).collect();
            for matrix in [&mut self, &mut *right] {
                for j in 0..matrix.columns {
                    let column = matrix.column_mut(j);
                    let head = column[step];
                    if head != 0.0 {
                        for (entry, factor) in column[step + 1..].iter_mut().zip(&factors) {
                            *entry -= factor * head;
                        }
                    }
                }
            }
        }
        for j in 0..right.columns {
            for step in (0..size).rev() {
                let value = right[(step, j)] / self[(step, step)];
                let column = right.column_mut(j);
                column[step] = value;
                for (entry, factor) in column[..step].iter_mut().zip(self.column(step)) {
                    *entry -= factor * value;
                }
            }
        }
    }

    fn swap_rows(&mut self, a: usize, b: usize) {
        for j in 0..self.columns {
            self.column_mut(j).swap(a, b);
        }
    }
}

impl Index<(usize, usize)> for Matrix {
    type Output = f64;
    #[inline]
    fn index(&self, (row, column): (usize, usize)) -> &f64 {
        &self.entries[column * self.rows + row]
    }
}

impl IndexMut<(usize, usize)> for Matrix {
    #[inline]
    fn index_mut(&mut self, (row, column): (usize, usize)) -> &mut f64 {
        &mut self.entries[column * self.rows + row]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_solution_solves() {
        let matrix = Matrix::from_rows(&[[0.0, 2.0, 1.0], [3.0, 0.0, -1.0], [1.0, 1.0, 0.0]]);
        let wanted = Matrix::from_rows(&[[1.0, -2.0], [0.5, 0.0], [4.0, 7.0]]);
        let mut right = matrix.times(&wanted);
        matrix.solve_into(&mut right);
        for (got, wanted) in right.entries().iter().zip(wanted.entries()) {
            assert!((got - wanted).abs() < 1e-14, "{got} {wanted}");
        }
    }

    #[test]
    fn blocks_add_up() {
        let mut matrix = Matrix::identity(3);
        matrix.add_block(1, 1, &Matrix::from_rows(&[[1.0, 2.0], [3.0, 4.0]]), -2.0);
        assert_eq!(matrix, Matrix::from_rows(&[[1.0, 0.0, 0.0], [0.0, -1.0, -4.0], [0.0, -6.0, -7.0]]));
        matrix.reset(1, 2);
        assert_eq!(matrix, Matrix::zeros(1, 2));
    }
}
