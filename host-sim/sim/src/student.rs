//! Student's t: how wide an interval of few values has to be.

use std::f64::consts::FRAC_PI_2;

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
