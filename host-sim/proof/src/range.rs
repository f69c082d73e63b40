//! Ranges of numbers, and what every operation of [`Scalar`] makes of them.
//!
//! A range holds every number from `lo` to `hi`, ends and infinities included, and, if `nan`, no number as well. An operation gives the
//! hull of what it gives for all operands. **No outward rounding**: rounding to nearest is monotone, so the end of a range is what the
//! operation itself, in the type that flies, gives at an end of its operands, to the bit. Only where an operation is not monotone
//! (sine, cosine, a quotient by what may be 0) is the range taken wider. A zero stands for both of its signs.

use cohold_core::num::Scalar;

/// A floating-point type whose ranges these are.
pub trait Float: Scalar<Counter = f64> {
    /// What ranges of it are called.
    const NAME_OF_RANGES: &'static str;
    /// The largest finite number, and the smallest above 0.
    const ENDS: [f64; 2];
    /// Relative spacing of the type's numbers.
    const EPSILON: f64;
    /// The next number above one of this type.
    fn above(number: f64) -> f64;
    /// The largest of this type that is no more than this.
    fn at_most(bound: f64) -> f64;
}

impl Float for f32 {
    const NAME_OF_RANGES: &'static str = "ranges of f32";
    const ENDS: [f64; 2] = [Self::MAX as f64, 1.401_298_464_324_817e-45];
    const EPSILON: f64 = Self::EPSILON as f64;
    fn above(number: f64) -> f64 {
        f64::from((number as Self).next_up())
    }
    fn at_most(bound: f64) -> f64 {
        let nearest = bound as Self;
        f64::from(if f64::from(nearest) > bound { nearest.next_down() } else { nearest })
    }
}

impl Float for f64 {
    const NAME_OF_RANGES: &'static str = "ranges of f64";
    const ENDS: [f64; 2] = [Self::MAX, 5e-324];
    const EPSILON: f64 = Self::EPSILON;
    fn above(number: f64) -> f64 {
        number.next_up()
    }
    fn at_most(bound: f64) -> f64 {
        bound
    }
}

/// The next number below one of this type.
pub(crate) fn below<F: Float>(number: f64) -> f64 {
    -F::above(-number)
}

/// The smallest of this type that is no less than this.
pub(crate) fn at_least<F: Float>(bound: f64) -> f64 {
    -F::at_most(-bound)
}

/// Every number between two, and perhaps none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The least; above `hi` if there is no number in it.
    pub lo: f64,
    /// The largest number in it.
    pub hi: f64,
    /// It may be no number.
    pub nan: bool,
}

impl Range {
    /// Any bits at all.
    pub const ANY: Self = Self { lo: f64::NEG_INFINITY, hi: f64::INFINITY, nan: true };
    /// The range without any number.
    pub const EMPTY: Self = Self::of(f64::INFINITY, f64::NEG_INFINITY);
    const NAN: Self = Self { nan: true, ..Self::EMPTY };

    /// From one number to another.
    pub const fn of(lo: f64, hi: f64) -> Self {
        Self { lo, hi, nan: false }
    }

    /// This number, which may be none.
    pub const fn point(number: f64) -> Self {
        if number.is_nan() { Self::NAN } else { Self::of(number, number) }
    }

    /// Every finite number of a type.
    pub fn finite<F: Float>() -> Self {
        let [most, _] = F::ENDS;
        Self::of(-most, most)
    }

    /// Whether there is any number in it.
    pub fn has_numbers(self) -> bool {
        self.lo <= self.hi
    }

    /// Whether nothing is left.
    pub fn is_empty(self) -> bool {
        !self.has_numbers() && !self.nan
    }

    /// One number, or none, and nothing else.
    pub fn is_point(self) -> bool {
        if self.nan { !self.has_numbers() } else { self.lo == self.hi }
    }

    /// Every number in it is one, and finite.
    pub fn is_finite(self) -> bool {
        !self.nan && self.lo > f64::NEG_INFINITY && self.hi < f64::INFINITY
    }

    /// Largest magnitude in it.
    pub fn most(self) -> f64 {
        self.hi.max(-self.lo)
    }

    /// Whether this number is in it.
    pub fn has(self, number: f64) -> bool {
        if number.is_nan() { self.nan } else { self.lo <= number && number <= self.hi }
    }

    fn has_infinity(self) -> bool {
        self.has(f64::INFINITY) || self.has(f64::NEG_INFINITY)
    }

    /// What is in both.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self::of(self.lo.max(other.lo), self.hi.min(other.hi)).with_nan(self.nan && other.nan)
    }

    /// What is in either, and what lies between.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self::of(self.lo.min(other.lo), self.hi.max(other.hi)).with_nan(self.nan || other.nan)
    }

    /// This, or no number if `nan`.
    pub(crate) fn with_nan(self, nan: bool) -> Self {
        Self { nan: self.nan || nan, ..self }
    }

    /// The numbers in it.
    pub(crate) fn numbers(self) -> Self {
        Self::of(self.lo, self.hi)
    }

    pub(crate) fn negative(self) -> Self {
        Self::of(-self.hi, -self.lo).with_nan(self.nan)
    }

    /// What a monotone operation of one number gives.
    fn each(self, nan: bool, one: impl Fn(f64) -> f64) -> Self {
        let numbers = if self.has_numbers() { Self::of(one(self.lo), one(self.hi)) } else { Self::EMPTY };
        numbers.with_nan(nan)
    }

    /// What an operation of two gives that is monotone in each, wherever the other is.
    fn corners<F: Float>(self, other: Self, nan: bool, both: impl Fn(F, F) -> F) -> Self {
        let mut hull = Self::EMPTY.with_nan(nan);
        if !(self.has_numbers() && other.has_numbers()) {
            return hull;
        }
        for a in [self.lo, self.hi] {
            for b in [other.lo, other.hi] {
                let corner = both(F::from_f64(a), F::from_f64(b)).to_f64();
                // 0·∞ and ∞/∞: what is next to such a corner may be as small as 0.
                hull = hull.or(Self::point(if corner.is_nan() { 0.0 } else { corner }));
            }
        }
        hull
    }
}

/// What an operation makes of two ranges of one type; the second is not looked at where it takes one.
pub(crate) fn of_two<F: Float>(op: Op, a: Range, b: Range) -> Range {
    let nan = a.nan || b.nan;
    match op {
        Op::Add => a.sum::<F>(b),
        Op::Sub => a.sum::<F>(b.negative()),
        Op::Mul => {
            let lost = a.has(0.0) && b.has_infinity() || b.has(0.0) && a.has_infinity();
            a.corners::<F>(b, nan || lost, |a, b| a * b)
        }
        Op::Neg => a.negative(),
        Op::Abs if a.has(0.0) => Range::of(0.0, a.most()).with_nan(a.nan),
        Op::Abs if a.hi < 0.0 => a.negative(),
        Op::Abs => a,
        // Of no number, and of one below 0, the root is 0.
        Op::Sqrt => {
            let root = a.each(false, |a| F::from_f64(a).sqrt().to_f64());
            if a.nan { root.or(Range::point(0.0)) } else { root }
        }
        Op::Ratio => {
            let quotient = a.over::<F>(b);
            if b.has(0.0) { quotient.or(Range::point(0.0)) } else { quotient }
        }
        Op::Over if b.has(0.0) => Range::ANY.numbers().with_nan(nan || a.has(0.0) || a.has_infinity()),
        Op::Over => a.over::<F>(b),
        Op::Limit => a.limit(b),
        // In both, what is no number loses if it comes first.
        Op::Max | Op::Min => {
            let pick = |a: f64, b: f64| if op == Op::Max { a.max(b) } else { a.min(b) };
            let both = if a.has_numbers() && b.has_numbers() {
                Range::of(pick(a.lo, b.lo), pick(a.hi, b.hi))
            } else {
                Range::EMPTY
            };
            (if a.nan { both.or(b) } else { both }).with_nan(b.nan)
        }
        // A sine of less than one unit in the last place too much may be above 1.
        Op::Sin | Op::Cos => {
            let most = 1.0 + 2.0 * F::EPSILON;
            if !a.has_numbers() {
                return Range::EMPTY.with_nan(nan);
            }
            // Of an infinite angle it is no number, nor of one too far from 0 for its type.
            let far = [a.lo, a.hi].iter().any(|end| !F::from_f64(*end).sin_cos().0.is_finite());
            Range::of(-most, most).with_nan(nan || far)
        }
        Op::ToCounter => a,
        Op::OfCounter => a.each(a.nan, |a| F::from_f64(a).to_f64()),
    }
}

impl Range {
    fn sum<F: Float>(self, other: Self) -> Self {
        let [up, down] = [f64::INFINITY, f64::NEG_INFINITY];
        let lost = self.has(up) && other.has(down) || self.has(down) && other.has(up);
        self.corners::<F>(other, self.nan || other.nan || lost, |a, b| a + b)
    }

    /// By every divisor but 0.
    fn over<F: Float>(self, divisor: Self) -> Self {
        let nan = self.nan || divisor.nan || self.has_infinity() && divisor.has_infinity();
        let [_, least] = F::ENDS;
        let by = |part: Self| self.corners::<F>(part, nan, |a, b| a.over(b));
        let above = Self::of(divisor.lo.max(least), divisor.hi);
        let under = Self::of(divisor.lo, divisor.hi.min(-least));
        by(above).or(by(under))
    }

    /// The range of [`Scalar::limit`].
    fn limit(self, bound: Self) -> Self {
        let within = self.and(Self::of(-bound.hi, bound.hi));
        let mut held = if within.has_numbers() { within } else { Self::EMPTY };
        if self.has_numbers() && bound.has_numbers() {
            let numbers = bound.numbers();
            if self.hi > bound.lo {
                held = held.or(numbers);
            }
            if self.lo < -bound.lo {
                held = held.or(numbers.negative());
            }
        }
        if self.nan || bound.nan {
            held = held.or(Self::point(0.0));
        }
        held.numbers()
    }
}

/// An operation on numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub(crate) enum Op {
    Add,
    Sub,
    Mul,
    Neg,
    Abs,
    Sqrt,
    Ratio,
    Over,
    Limit,
    Max,
    Min,
    Sin,
    Cos,
    ToCounter,
    OfCounter,
}
