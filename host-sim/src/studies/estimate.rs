//! A mean over seeds, and how sure it is.

use std::f64::consts::FRAC_PI_2;

/// A mean over seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Mean.
    pub mean: f64,
    /// The true mean is that far from it at most, with 95 % confidence (Student); nothing of a single run.
    pub within_95: Option<f64>,
}

impl Estimate {
    /// Of values from as many seeds, or of the one that is sure.
    pub fn of(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
        let within = || student_95(values.len() as u32 - 1) * (squares / (count - 1.0) / count).sqrt();
        Self { mean, within_95: (values.len() > 1).then(within) }
    }
}

/// Student's t for a two-sided 95 % interval with that many degrees of freedom, 1 or more; rounded to 10⁻⁹ of itself.
pub fn student_95(freedom: u32) -> f64 {
    // In terms of t = √ν·tan θ the chance of a smaller |t| is a finite sum that grows with θ (Abramowitz and Stegun 26.7.3, 26.7.4).
    let (mut low, mut high) = (0.0, FRAC_PI_2);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *(if smaller(middle, freedom) < 0.95 { &mut low } else { &mut high }) = middle;
    }
    f64::from(freedom).sqrt() * libm::tan(low)
}

/// The chance of a |t| below √ν·tan θ.
fn smaller(theta: f64, freedom: u32) -> f64 {
    let (sine, cosine) = (libm::sin(theta), libm::cos(theta));
    let odd = freedom % 2 == 1;
    let (mut term, mut sum) = (if odd { cosine } else { 1.0 }, 0.0);
    let mut power = if odd { 1 } else { 0 };
    while power + 2 <= freedom {
        sum += term;
        power += 2;
        term *= cosine * cosine * f64::from(power - 1) / f64::from(power);
    }
    if odd { (theta + sine * sum) / FRAC_PI_2 } else { sine * sum }
}

#[cfg(test)]
#[path = "../../tests/inside/studies_estimate.rs"]
mod tests;
