//! What the analysis asks of dense matrices (`nalgebra`) besides their own operators.
//!
//! Units are those of the states that rows and columns stand for.

/// Rows × columns of `f64`, stored column by column.
pub type Matrix = nalgebra::DMatrix<f64>;

/// All zeros in another shape, in the memory that is there.
pub(crate) fn reset(matrix: &mut Matrix, rows: usize, columns: usize) {
    matrix.resize_mut(rows, columns, 0.0);
    matrix.fill(0.0);
}

/// One column of the matrix.
pub(crate) fn column(matrix: &Matrix, at: usize) -> &[f64] {
    &matrix.as_slice()[at * matrix.nrows()..][..matrix.nrows()]
}

/// One column, to write.
pub(crate) fn column_mut(matrix: &mut Matrix, at: usize) -> &mut [f64] {
    let rows = matrix.nrows();
    &mut matrix.as_mut_slice()[at * rows..][..rows]
}

/// Adds `factor` times `block` with its corner at (`row`, `left`).
pub(crate) fn add_block(matrix: &mut Matrix, row: usize, left: usize, block: &Matrix, factor: f64) {
    for j in 0..block.ncols() {
        let target = &mut column_mut(matrix, left + j)[row..row + block.nrows()];
        for (out, entry) in target.iter_mut().zip(column(block, j)) {
            *out += factor * entry;
        }
    }
}

/// A matrix times a vector; a factor of 0 leaves out what is not finite.
pub fn apply(matrix: &Matrix, vector: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; matrix.nrows()];
    for (j, factor) in vector.iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
        for (out, entry) in product.iter_mut().zip(column(matrix, j)) {
            *out += entry * factor;
        }
    }
    product
}
