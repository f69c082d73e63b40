//! Numbers for people.

use cohold_io::significant;

#[test]
fn significant_digits_keep_the_integer_part() {
    let cases = [(3.5, "3.50"), (0.09871, "0.0987"), (10620.4, "10620"), (-0.6437, "-0.644"), (0.0, "0")];
    for (value, text) in cases {
        assert_eq!(significant(value, 3), text);
    }
    assert_eq!(significant(0.99999, 3), "1.00");
    assert_eq!(significant(1.5e-7, 2), "1.5e-7");
    assert_eq!(significant(2e12, 2), "2.0e12");
    assert_eq!(significant(f64::NAN, 3), "NaN");
    assert_eq!(significant(f64::NEG_INFINITY, 0), "-inf");
}
