//! Fixed point against exact integers: sums, quotients and roundings, ends of the range and ties included.

use cohold_core::num::{Fixed, Scalar};
use proptest::prelude::*;

/// A step, 2⁻³², in each of 1.
const ONE: i128 = 1 << 32;

fn bits(number: Fixed) -> i128 {
    i128::from(number.bits().cast_signed())
}

fn within(exact: i128) -> i128 {
    exact.clamp(i64::MIN.into(), i64::MAX.into())
}

/// Any bits; few; ends and ties, a step beside them included.
fn any_bits() -> impl Strategy<Value = i64> {
    let special = [0, 1, 1 << 31, 1 << 32, 3 << 31, i64::MAX, i64::MIN, i64::MAX - (1 << 31)];
    let near = (0..special.len(), -1_i64..=1, any::<bool>());
    let near = near.prop_map(move |(at, beside, negative)| {
        let bits = special[at].wrapping_add(beside);
        if negative { bits.wrapping_neg() } else { bits }
    });
    prop_oneof![any::<i64>(), -20_i64..20, near]
}

proptest! {
    #[test]
    fn every_operation_is_the_exact_one_rounded_and_saturated(a in any_bits(), b in any_bits()) {
        let [x, y] = [a, b].map(Fixed::from_bits);
        let [a, b] = [a, b].map(i128::from);
        prop_assert_eq!(bits(x + y), within(a + b));
        prop_assert_eq!(bits(x - y), within(a - b));
        prop_assert_eq!(bits(-x), within(-a));
        // To the nearest, ties away from zero.
        let product = (a * b).abs();
        prop_assert_eq!(bits(x * y), within((a * b).signum() * ((product + ONE / 2) / ONE)));
        // Towards zero, and 0 by 0.
        prop_assert_eq!(bits(x.ratio(y)), if b == 0 { 0 } else { within(a * ONE / b) });
        let nearest = a.signum() * ((a.abs() + ONE / 2) / ONE);
        prop_assert_eq!(i128::from(x.round_to_i32()), nearest.clamp(i32::MIN.into(), i32::MAX.into()));
        // 53 bits of 64, the nearest.
        let there = x.to_f64();
        let step = f64::EPSILON * there.abs();
        prop_assert!(((there * ONE as f64) as i128 - a).abs() as f64 <= step * ONE as f64 / 2.0);
        if a.abs() < 1 << 53 {
            prop_assert_eq!(Fixed::from_f64(there), x);
        }
        prop_assert_eq!(x.partial_cmp(&y), a.partial_cmp(&b));
    }
}
