//! Numbers as a reader wants them.

/// A number with at least `digits` significant digits, and never fewer than its integer part needs:
/// `significant(0.09871, 3)` is `0.0987`, `significant(10620.0, 3)` is `10620`. Below 1e-4 and from 1e9 up in
/// scientific notation.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".to_owned() } else { value.to_string() };
    }
    let after_first = digits.clamp(1, 17) - 1;
    let exponential = format!("{value:.after_first$e}");
    let exponent = exponential.split_once('e').and_then(|(_, e)| e.parse::<i32>().ok()).unwrap_or(0);
    if !(-4..9).contains(&exponent) {
        return exponential;
    }
    let decimals = usize::try_from(after_first as i32 - exponent).unwrap_or(0);
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
