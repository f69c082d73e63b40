//! What the analysis asks of dense matrices (`faer`) besides their own operators.
//!
//! Units are those of the states that rows and columns stand for.

/// Rows × columns of `f64`, stored column by column.
pub type Matrix = faer::Mat<f64>;

/// All zeros in another shape, in the memory that is there.
pub(crate) fn reset(matrix: &mut Matrix, rows: usize, columns: usize) {
    matrix.resize_with(rows, columns, |_, _| 0.0);
    matrix.fill(0.0);
}

/// Adds `factor` times `block` with its corner at (`row`, `column`).
pub(crate) fn add_block(matrix: &mut Matrix, row: usize, column: usize, block: &Matrix, factor: f64) {
    for j in 0..block.ncols() {
        let target = &mut matrix.col_as_slice_mut(column + j)[row..row + block.nrows()];
        for (out, entry) in target.iter_mut().zip(block.col_as_slice(j)) {
            *out += factor * entry;
        }
    }
}

/// A matrix times a vector; a factor of 0 leaves out what is not finite.
pub fn apply(matrix: &Matrix, vector: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; matrix.nrows()];
    for (j, factor) in vector.iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
        for (out, entry) in product.iter_mut().zip(matrix.col_as_slice(j)) {
            *out += entry * factor;
        }
    }
    product
}
