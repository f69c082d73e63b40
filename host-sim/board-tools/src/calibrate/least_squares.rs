//! Least squares in a few unknowns, by the normal equations.

/// The unknowns of `row · unknowns = right`, each with its standard error; none where the rows do not tell them apart.
pub(super) fn solve<const N: usize>(rows: &[([f64; N], f64)]) -> Option<[(f64, f64); N]> {
    let scale: [f64; N] = std::array::from_fn(|j| rows.iter().map(|(row, _)| row[j] * row[j]).sum::<f64>().sqrt());
    if scale.iter().any(|scale| scale.is_nan() || *scale <= 0.0) {
        return None;
    }
    // AᵀA, columns scaled to length 1, beside what becomes its inverse by Gauss and Jordan.
    let mut table = [[[0.0; N]; 2]; N];
    let mut right = [0.0; N];
    for (row, y) in rows {
        for i in 0..N {
            for j in 0..N {
                table[i][0][j] += row[i] / scale[i] * (row[j] / scale[j]);
            }
            right[i] += row[i] / scale[i] * y;
        }
    }
    for (i, line) in table.iter_mut().enumerate() {
        line[1][i] = 1.0;
    }
    for pivot in 0..N {
        let best = (pivot..N).max_by(|&a, &b| table[a][0][pivot].abs().total_cmp(&table[b][0][pivot].abs()))?;
        table.swap(pivot, best);
        let head = table[pivot];
        if head[0][pivot].abs() < 1e-9 {
            return None;
        }
        for (i, line) in table.iter_mut().enumerate() {
            let factor = if i == pivot { 1.0 - 1.0 / head[0][pivot] } else { line[0][pivot] / head[0][pivot] };
            for (cell, head) in line.as_flattened_mut().iter_mut().zip(head.as_flattened()) {
                *cell -= factor * head;
            }
        }
    }
    let solution: [f64; N] = std::array::from_fn(|i| (0..N).map(|j| table[i][1][j] * right[j]).sum::<f64>() / scale[i]);
    let squares: f64 =
        rows.iter().map(|(row, y)| (y - row.iter().zip(solution).map(|(a, x)| a * x).sum::<f64>()).powi(2)).sum();
    let variance = squares / (rows.len() - N) as f64;
    Some(std::array::from_fn(|i| (solution[i], (variance * table[i][1][i]).sqrt() / scale[i])))
}
