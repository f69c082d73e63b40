//! Numbers of twice the digits of f64: what f64 itself is measured against.
//!
//! A value is the unevaluated sum of two f64, the second below half a step of the first: about 32 digits (relative
//! error of every operation below 1e-30, of sine and cosine below 1e-29 of the circle for angles up to 1e3 rad). It is
//! a [`Scalar`], so the peer of the board can be run in it. Slow (about 20 operations for one), for references only.
//!
//! Range: that of f64 above 1e-290, where the products' low halves still exist. Not correctly rounded.
//!
//! References: Dekker, "A floating-point technique for extending the available precision", Numer. Math. 18, 1971;
//! Hida, Li & Bailey, "Algorithms for quad-double precision floating point arithmetic", ARITH-15, 2001.

use std::ops::{Add, Mul, Neg, Sub};

use cohold_core::num::Scalar;

/// A number of about 32 decimal digits: the sum of two f64.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct DoubleDouble {
    high: f64,
    low: f64,
}

const QUARTER_TURN: DoubleDouble = of(std::f64::consts::FRAC_PI_2, 6.123_233_995_736_766e-17);

const fn of(high: f64, low: f64) -> DoubleDouble {
    DoubleDouble { high, low }
}

/// a + b exactly, as a sum of two.
fn two_sum(a: f64, b: f64) -> DoubleDouble {
    let high = a + b;
    let part = high - a;
    of(high, (a - (high - part)) + (b - part))
}

/// [`two_sum`] where |a| ≥ |b|, in fewer operations.
fn quick_two_sum(a: f64, b: f64) -> DoubleDouble {
    let high = a + b;
    of(high, b - (high - a))
}

/// A number as two of 26 bits (Veltkamp's split).
fn split(a: f64) -> (f64, f64) {
    let shifted = 134_217_729.0 * a;
    let high = shifted - (shifted - a);
    (high, a - high)
}

/// a·b exactly, as a sum of two.
fn two_product(a: f64, b: f64) -> DoubleDouble {
    let high = a * b;
    let ((a1, a2), (b1, b2)) = (split(a), split(b));
    of(high, ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2)
}

impl Add for DoubleDouble {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (mut sum, rest) = (two_sum(self.high, other.high), two_sum(self.low, other.low));
        sum = quick_two_sum(sum.high, sum.low + rest.high);
        quick_two_sum(sum.high, sum.low + rest.low)
    }
}
impl Neg for DoubleDouble {
    type Output = Self;
    fn neg(self) -> Self {
        of(-self.high, -self.low)
    }
}
impl Sub for DoubleDouble {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}
impl Mul for DoubleDouble {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let product = two_product(self.high, other.high);
        quick_two_sum(product.high, product.low + (self.high * other.low + self.low * other.high))
    }
}

impl Scalar for DoubleDouble {
    type Counter = f64;
    const NAME: &'static str = "double-double";
    const ZERO: Self = of(0.0, 0.0);
    const ONE: Self = of(1.0, 0.0);

    fn from_f64(value: f64) -> Self {
        of(value, 0.0)
    }
    /// Rounded to 53 bits.
    fn to_f64(self) -> f64 {
        self.high
    }
    fn to_counter(self) -> f64 {
        self.to_f64()
    }
    fn of_counter(counter: f64) -> Self {
        Self::from_f64(counter)
    }
    fn from_i32(value: i32) -> Self {
        Self::from_f64(f64::from(value))
    }
    fn round_to_i32(self) -> i32 {
        Scalar::round_to_i32(self.high)
    }
    fn is_finite(self) -> bool {
        self.high.is_finite()
    }
    fn bits(self) -> u64 {
        self.high.to_bits() ^ self.low.to_bits().rotate_left(32)
    }
    fn sqrt(self) -> Self {
        if self.high <= 0.0 {
            return Self::ZERO;
        }
        // Newton's step from the f64 root doubles its digits.
        let root = Self::from_f64(self.high.sqrt());
        root + Self::from_f64((self - root * root).high / (2.0 * root.high))
    }
    fn sin_cos(self) -> (Self, Self) {
        let quarters = (self.high / QUARTER_TURN.high).round();
        let rest = self - QUARTER_TURN * Self::from_f64(quarters);
        let (sine, cosine) = taylor(rest);
        match (quarters as i64).rem_euclid(4) {
            0 => (sine, cosine),
            1 => (cosine, -sine),
            2 => (-sine, -cosine),
            _ => (-cosine, sine),
        }
    }
    fn ratio(self, divisor: Self) -> Self {
        if divisor.high == 0.0 {
            return Self::ZERO;
        }
        // Long division, three digits of 53 bits.
        let mut quotient = Self::ZERO;
        let mut rest = self;
        for _ in 0..3 {
            let digit = Self::from_f64(rest.high / divisor.high);
            quotient = quotient + digit;
            rest = rest - digit * divisor;
        }
        quotient
    }
}

/// Sine and cosine for angles up to π/4, by their series.
fn taylor(angle: DoubleDouble) -> (DoubleDouble, DoubleDouble) {
    let (mut sine, mut cosine, mut term) = (DoubleDouble::ZERO, DoubleDouble::ONE, DoubleDouble::ONE);
    for order in 1..=28 {
        term = (term * angle).ratio(DoubleDouble::from_i32(order));
        let signed = if order % 4 < 2 { term } else { -term };
        if order % 2 == 1 { sine = sine + signed } else { cosine = cosine + signed }
    }
    (sine, cosine)
}
