//! Numbers for people.

/// A number with at least `digits` significant digits, and never fewer than its integer part needs: `significant(0.09871, 3)` is `0.0987`,
/// `significant(10620.0, 3)` is `10620`. Below 1e-4 and from 1e9 up in scientific notation.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return value.to_string();
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
