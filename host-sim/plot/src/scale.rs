//! Scales: a range of values on a linear or logarithmic axis, and its ticks.
//!
//! Ticks stand at 1, 2 or 5 times a power of ten. A logarithmic axis shows whole decades, with 2 and 5 between them when it spans at most
//! two, and even ticks when it spans less than that can label. Texts carry the decimals that neighbouring ticks need to differ; from 1e6
//! up and below 1e-4 they are multiples or powers of ten (`font` sets `10^−6` as it should be).

/// Larger magnitudes cannot be shown: differences of ranges would overflow.
pub(crate) const HUGE: f64 = 1e300;

/// A range of values, `lo < hi`, both finite; positive if the axis is logarithmic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale {
    pub(crate) lo: f64,
    pub(crate) hi: f64,
    pub(crate) log: bool,
}

impl Scale {
    /// The scale over a range, put in order; around a constant; 0…1 (1…10) where the range cannot be shown.
    pub(crate) fn new((a, b): (f64, f64), log: bool) -> Self {
        let (lo, hi) = (a.min(b), a.max(b));
        if !showable(a, log) || !showable(b, log) {
            return if log { Self { lo: 1.0, hi: 10.0, log } } else { Self { lo: 0.0, hi: 1.0, log } };
        }
        // Relative: a range narrower than the rounding of its ticks cannot be labelled.
        if hi - lo > 1e-9 * hi.abs().max(lo.abs()).max(1e-290) {
            return Self { lo, hi, log };
        }
        let around = if lo.abs() < 1e-290 { 1.0 } else { 0.1 * lo.abs() };
        if log { Self { lo: lo / 2.0, hi: hi * 2.0, log } } else { Self { lo: lo - around, hi: hi + around, log } }
    }

    /// Where a value lies: 0 at `lo`, 1 at `hi`; not finite if the axis cannot show it.
    pub(crate) fn fraction(&self, value: f64) -> f64 {
        let (lo, hi, value) =
            if self.log { (self.lo.ln(), self.hi.ln(), value.ln()) } else { (self.lo, self.hi, value) };
        (value - lo) / (hi - lo)
    }

    /// Whether a value lies in the range, up to rounding.
    pub(crate) fn holds(&self, value: f64) -> bool {
        (-1e-9..=1.0 + 1e-9).contains(&self.fraction(value))
    }

    /// The scale with these fractions of its length added below and above.
    pub(crate) fn widened(&self, below: f64, above: f64) -> Self {
        if self.log {
            let length = self.hi.ln() - self.lo.ln();
            Self::new((self.lo * (-below * length).exp(), self.hi * (above * length).exp()), true)
        } else {
            let length = self.hi - self.lo;
            Self::new((self.lo - below * length, self.hi + above * length), false)
        }
    }

    /// Labelled ticks inside the range, about `count` of them, with their texts.
    pub(crate) fn ticks(&self, count: usize) -> Vec<(f64, String)> {
        // One tick is no scale: then more are asked for.
        let two = |of: &dyn Fn(usize) -> Vec<(f64, String)>| (count..=3 * count + 3).map(of).find(|it| it.len() >= 2);
        let decades = || two(&|count| self.decade_ticks(count)).filter(|_| self.log);
        decades().or_else(|| two(&|count| self.even_ticks(count))).unwrap_or_default()
    }

    /// Unlabelled ticks at 2…9 times the powers of ten; none on a linear axis or over more than six decades.
    pub(crate) fn minor_ticks(&self) -> Vec<f64> {
        if !self.log || self.hi.log10() - self.lo.log10() > 6.0 {
            return Vec::new();
        }
        let decade = |e: i32| (2..10).map(move |m| f64::from(m) * 10f64.powi(e));
        let decades = self.lo.log10().floor() as i32..=self.hi.log10().ceil() as i32;
        decades.flat_map(decade).filter(|v| self.holds(*v)).collect()
    }

    fn decade_ticks(&self, count: usize) -> Vec<(f64, String)> {
        let (first, last) = (self.lo.log10().floor() as i32, self.hi.log10().ceil() as i32);
        let every = last.abs_diff(first) as usize / count.max(2) + 1;
        let steps: &[f64] = if self.hi.log10() - self.lo.log10() <= 2.0 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let values = (first..=last).step_by(every).flat_map(|e| steps.iter().map(move |m| m * 10f64.powi(e)));
        let values: Vec<f64> = values.filter(|v| self.holds(*v)).collect();
        // All as powers or none, so that one axis speaks one language.
        let powers = match steps {
            [_] => first < -3 || last > 5,
            _ => values.iter().any(|v| !PLAIN.contains(&exponent(*v))),
        };
        let power = |v: f64| {
            let exponent = exponent(v);
            let multiple = (v / 10f64.powf(exponent)).round();
            let sign = if multiple == 1.0 { String::new() } else { format!("{multiple}×") };
            format!("{sign}10^{exponent}").replace('-', "−")
        };
        values.into_iter().map(|v| (v, if powers { power(v) } else { text(v, v, v) })).collect()
    }

    fn even_ticks(&self, count: usize) -> Vec<(f64, String)> {
        let rough = (self.hi - self.lo) / count.max(1) as f64;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0].iter().map(|m| m * power).find(|s| *s >= 0.999 * rough).unwrap_or(10.0 * power);
        let (first, last) = ((self.lo / step - 1e-6).ceil(), (self.hi / step + 1e-6).floor());
        let values = (0..=(last - first).clamp(0.0, 50.0) as usize).map(|i| (first + i as f64) * step);
        let largest = self.lo.abs().max(self.hi.abs());
        values.filter(|v| self.holds(*v)).map(|v| (v, text(v, step, largest))).collect()
    }
}

/// Whether an axis can show this value at all.
pub(crate) fn showable(value: f64, log: bool) -> bool {
    value.abs() <= HUGE && (!log || value >= 1.0 / HUGE)
}

/// Powers of ten that are written out.
const PLAIN: std::ops::Range<f64> = -4.0..6.0;

/// The power of ten of a value. One part in 1e9 up: log10 of 1e-3 may come out just below −3.
fn exponent(value: f64) -> f64 {
    (value.abs().log10() + 1e-9).floor()
}

/// A tick's value with the decimals that tell it from one `step` further, as a multiple of the power of ten of the axis'
/// `largest` value where that is far from 1.
fn text(value: f64, step: f64, largest: f64) -> String {
    if value.abs() < 1e-6 * step {
        return "0".to_owned();
    }
    let power = Some(exponent(largest)).filter(|e| !PLAIN.contains(e)).unwrap_or(0.0);
    let decimals = (power - exponent(step)).clamp(0.0, 12.0) as usize;
    let multiple = value / 10f64.powf(power);
    let suffix = if power == 0.0 { String::new() } else { format!("×10^{power}") };
    format!("{multiple:.decimals$}{suffix}").replace('-', "−")
}

#[cfg(test)]
#[path = "../tests/inside/scale.rs"]
mod tests;
