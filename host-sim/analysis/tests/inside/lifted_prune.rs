//! Tests of `src/lifted/prune.rs` from inside.

use super::*;
use crate::oracle::rows;

#[test]
fn dead_and_silent_chains_go() {
    // 0 ↔ 1 live; 2 → 3 → 0 is fed by nothing; 1 → 4 is read by nothing; 5 only remembers itself.
    let mut matrix = Matrix::zeros(6, 6);
    for (to, from) in [(0, 0), (0, 1), (1, 0), (3, 2), (0, 3), (4, 1), (5, 5)] {
        matrix[(to, from)] = 0.5;
    }
    assert_eq!(kept(&matrix, &[0]), [0, 1]);
    assert_eq!(kept(&matrix, &[0, 5]), [0, 1, 5]);
    let mut pruner = Pruner::default();
    for devices in [&[0][..], &[0, 5], &[0, 5], &[0]] {
        assert_eq!(pruner.kept(&matrix, devices), kept(&matrix, devices));
    }
    let mut other = matrix.clone();
    other[(2, 4)] = 1.0;
    assert_eq!(pruner.kept(&other, &[0]), [0, 1, 2, 3, 4]);
    let from = Lifted { matrix, rest_modes: vec![vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]] };
    let mut to = Lifted::default();
    copy(&from, &[0, 1], &mut to);
    assert_eq!(to.matrix, rows([[0.5, 0.5], [0.5, 0.0]]));
    assert_eq!(to.rest_modes, [[1.0, 2.0]]);
}
