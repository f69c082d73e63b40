//! Twice the digits of f64: sums, quotients, roots and sines, against what must hold of them.

use cohold_core::num::Scalar;
use cohold_sim::double_double::DoubleDouble;

fn number(value: f64) -> DoubleDouble {
    DoubleDouble::from_f64(value)
}

/// How far two values are apart, of the first.
fn difference(a: DoubleDouble, b: DoubleDouble) -> f64 {
    ((a - b).to_f64() / a.to_f64()).abs()
}

#[test]
fn sums_keep_what_f64_loses() {
    let sum = number(1.0) + number(1e-25);
    assert_eq!((sum - number(1.0)).to_f64(), 1e-25);
}

#[test]
fn products_and_quotients_undo_each_other() {
    for divisor in [3.0, 7.25e-3, -123_456.789, 1e-9] {
        let third = number(1.0).ratio(number(divisor));
        assert!(difference(number(1.0), third * number(divisor)) < 1e-31, "{divisor}");
    }
    assert_eq!(number(2.0).ratio(DoubleDouble::ZERO), DoubleDouble::ZERO);
}

#[test]
fn roots_square_back() {
    for value in [2.0, 0.1, 1e-12, 7e9] {
        let root = number(value).sqrt();
        assert!(difference(number(value), root * root) < 1e-30, "{value}");
    }
    assert_eq!(number(-1.0).sqrt(), DoubleDouble::ZERO);
}

/// sin² + cos² = 1 and the sum of angles hold to 30 digits; f64's own sine is met to its last digit.
#[test]
fn sine_and_cosine_hold_their_identities() {
    for at in -40..40 {
        let angle = number(0.37 * f64::from(at) + 0.01);
        let (sine, cosine) = angle.sin_cos();
        assert!(difference(DoubleDouble::ONE, sine * sine + cosine * cosine) < 1e-29);
        let (double, _) = (angle + angle).sin_cos();
        assert!((double - number(2.0) * sine * cosine).abs().to_f64() < 1e-29);
        assert!((sine.to_f64() - angle.to_f64().sin()).abs() < 2e-16);
    }
}
