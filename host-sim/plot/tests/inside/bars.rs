//! Tests of `src/bars.rs` from inside.

use super::*;

#[test]
fn values_carry_no_zeros_that_say_nothing() {
    let cases = [(3.5, "3.5"), (0.099, "0.099"), (10620.0, "10620"), (-2.0, "−2"), (f64::NAN, "NaN"), (0.0, "0")];
    for (value, text) in cases {
        assert_eq!(value_text(value), text);
    }
}
