//! Divides rest modes out of a lifted matrix by their eigenvectors.
//!
//! A rest mode v stays as it is: M·v = v. On the quotient by span(v) the matrix keeps all its other eigenvalues: with p the
//! largest component of v, M′ᵢⱼ = Mᵢⱼ − (vᵢ/v_p)·M_pj, without row and column p. No eigenvalue is looked at, so one that
//! happens to lie near 1 is never taken for a rest mode.
//!
//! Which vectors rest is known beforehand (THEORY §3): translations, tested by driving the peer there
//! ([`super::driven`]), and single coordinates that nothing depends on but themselves ([`idle`]).

use super::Lifted;

/// Adds to the rest modes every coordinate whose column is exactly its unit vector: where it stands is felt by nothing.
/// A device in a scene without contact and arm is the example.
pub(crate) fn idle(lifted: &mut Lifted) {
    let size = lifted.matrix.nrows();
    for at in 0..size {
        let column = lifted.matrix.col_as_slice(at);
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
        let mut quotient = crate::matrix::Matrix::zeros(size - 1, size - 1);
        for (column, j) in (0..size).filter(|j| *j != pivot).enumerate() {
            let source = lifted.matrix.col_as_slice(j);
            let share = source[pivot] / head;
            let rows = (0..size).filter(|i| *i != pivot);
            for (out, i) in quotient.col_as_slice_mut(column).iter_mut().zip(rows) {
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
mod tests {
    use faer::linalg::solvers::DenseSolveCore;
    use faer::mat;

    use super::*;
    use crate::matrix::Matrix;
    use crate::spectrum::Spectrum;

    /// S·diag·S⁻¹ for a basis S given by its columns.
    fn with_eigenvectors(basis: &Matrix, values: &[f64]) -> Matrix {
        let scaled = Matrix::from_fn(basis.nrows(), values.len(), |i, j| basis[(i, j)] * values[j]);
        scaled * basis.partial_piv_lu().inverse()
    }

    fn basis() -> Matrix {
        mat![
            [1.0, 0.0, 0.3, -0.2, 0.1],
            [1.0, 0.0, -0.5, 0.4, 0.0],
            [0.0, 2.0, 0.2, 0.1, -0.7],
            [0.0, 2.0, 0.0, -0.3, 0.6],
            [0.5, 0.0, 0.9, 0.8, 0.2],
        ]
    }

    #[test]
    fn only_the_rest_modes_go() {
        // Three eigenvalues of 1 or nearly so; two of them are rest modes, the third is not.
        let values = [1.0, 1.0, 0.999_999_999, -0.4, 0.25];
        let matrix = with_eigenvectors(&basis(), &values);
        let modes = vec![basis().col_as_slice(0).to_vec(), basis().col_as_slice(1).to_vec()];
        let mut lifted = Lifted { matrix, rest_modes: modes };
        assert_eq!(divide_out(&mut lifted), 2);
        assert_eq!(lifted.matrix.nrows(), 3);
        let mut left: Vec<f64> = Spectrum::default().eigenvalues(&lifted.matrix).unwrap().map(|(re, _)| re).collect();
        left.sort_by(f64::total_cmp);
        for (got, wanted) in left.iter().zip([-0.4, 0.25, 0.999_999_999]) {
            assert!((got - wanted).abs() < 1e-13, "{got} {wanted}");
        }
    }

    #[test]
    fn dependent_modes_count_once() {
        let matrix = with_eigenvectors(&basis(), &[1.0, 1.0, 0.5, 0.5, 0.5]);
        let (first, second) = (basis().col_as_slice(0).to_vec(), basis().col_as_slice(1).to_vec());
        let sum = first.iter().zip(&second).map(|(a, b)| a - 3.0 * b).collect();
        let mut lifted = Lifted { matrix, rest_modes: vec![first, sum, second] };
        assert_eq!(divide_out(&mut lifted), 2);
        assert!((Spectrum::default().radius(&mut lifted.matrix).unwrap() - 0.5).abs() < 1e-13);
    }

    #[test]
    fn an_unstable_eigenvalue_survives() {
        let matrix = with_eigenvectors(&basis(), &[1.0, 1.5, 0.5, 0.5, 0.5]);
        let mut lifted = Lifted { matrix, rest_modes: vec![basis().col_as_slice(0).to_vec()] };
        assert_eq!(divide_out(&mut lifted), 1);
        assert!((Spectrum::default().radius(&mut lifted.matrix).unwrap() - 1.5).abs() < 1e-13);
    }

    #[test]
    fn idle_coordinates_are_found_once() {
        let mut lifted = Lifted {
            matrix: mat![[1.0, 0.5, 0.0], [0.0, 0.5, 0.0], [0.0, 0.1, 1.0]],
            rest_modes: vec![vec![2.0, 0.0, 0.0]],
        };
        idle(&mut lifted);
        assert_eq!(lifted.rest_modes.len(), 2);
        assert_eq!(divide_out(&mut lifted), 2);
        assert_eq!(lifted.matrix, mat![[0.5]]);
    }
}
