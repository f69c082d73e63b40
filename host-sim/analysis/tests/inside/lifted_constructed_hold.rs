//! Tests of `src/lifted/constructed/hold.rs` from inside.

use super::*;

#[test]
fn a_rotation_is_a_rotation() {
    for angle in [1e-9_f64, 0.3, 2.0, 40.0] {
        let turned = exponential(&rows([[0.0, -angle], [angle, 0.0]]));
        assert!((turned[(0, 0)] - angle.cos()).abs() < 1e-14 * (1.0 + angle));
        assert!((turned[(1, 0)] - angle.sin()).abs() < 1e-14 * (1.0 + angle));
    }
}

#[test]
fn late_and_prompt_forces_add_up_to_a_held_one() {
    let (whole, split) = (Held::exact(0.2, 3.0, 80.0, 0.0, 1e-3), Held::exact(0.2, 3.0, 80.0, 0.37, 1e-3));
    for i in 0..2 {
        assert!((split.before[i] + split.now[i] - whole.now[i]).abs() < 1e-17);
        assert_eq!(whole.before[i], 0.0);
    }
}
