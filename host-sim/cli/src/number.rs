//! Numbers on the command line.

use std::ops::RangeInclusive;

use super::Failure;

/// A number on the command line, both ends included.
pub fn number(
    allowed: RangeInclusive<f64>,
    unit: &'static str,
) -> impl Fn(&str) -> Result<f64, Failure> + Clone + Send + Sync + 'static {
    move |text| {
        let number = text.parse().ok().filter(|number| allowed.contains(number));
        let (least, most) = (allowed.start(), allowed.end());
        number.ok_or_else(|| format!("it must be a number from {least} to {most} {unit}").trim_end().into())
    }
}
