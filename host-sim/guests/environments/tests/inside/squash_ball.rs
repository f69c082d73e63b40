//! The square root that a ball is flown with.

use super::root;

#[test]
fn the_root_is_within_2_ulp() {
    for n in 0..200_000_u32 {
        let number = f32::from_bits(0x0080_0000 + n * 10_000);
        let exact = f64::from(number).sqrt();
        assert!(((f64::from(root(number)) - exact) / exact).abs() < 2.4e-7, "{number}");
    }
}
