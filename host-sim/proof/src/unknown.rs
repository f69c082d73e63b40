//! A number of which only a range is known, as a number type of the peer.

use std::cmp::Ordering;
use std::fmt;
use std::marker::PhantomData;
use std::ops::{Add, Mul, Neg, Sub};

use cohold_core::num::Scalar;

use crate::graph::{self, Place};
use crate::range::{Float, Op, Range};

/// Index of a node in this thread's computation graph, whose numbers are of the type `F`.
#[derive(Clone, Copy)]
pub struct Unknown<F> {
    place: Place,
    of: PhantomData<F>,
}

/// What the peer of a board computes in, of which only a range is known.
pub type Number = Unknown<f32>;

impl<F: Float> Unknown<F> {
    pub(crate) const fn at(place: Place) -> Self {
        Self { place, of: PhantomData }
    }

    pub(crate) fn place(self) -> Place {
        self.place
    }

    /// Any number of this range.
    pub fn within(range: Range) -> Self {
        Self::at(graph::unknown(range))
    }

    /// Any bits at all.
    pub fn any() -> Self {
        Self::within(Range::ANY)
    }

    /// Any finite number of the type.
    pub fn any_finite() -> Self {
        Self::within(Range::finite::<F>())
    }

    /// What is known of it.
    pub fn range(self) -> Range {
        graph::range(self.place)
    }

    fn of_one(self, op: Op) -> Self {
        self.with(op, self)
    }

    /// Sine and cosine of one number.
    fn angle(self, sin_cos: impl Fn(F) -> (F, F)) -> Option<(Self, Self)> {
        let Range { lo, hi, nan } = self.range();
        let (sine, cosine) = (lo == hi && !nan).then(|| sin_cos(F::from_f64(lo)))?;
        Some((Self::from_f64(sine.to_f64()), Self::from_f64(cosine.to_f64())))
    }

    fn with(self, op: Op, other: Self) -> Self {
        Self::at(graph::compute::<F>(op, self.place, other.place))
    }
}

impl<F: Float> Default for Unknown<F> {
    fn default() -> Self {
        Self::ZERO
    }
}

impl<F: Float> fmt::Debug for Unknown<F> {
    fn fmt(&self, text: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Range { lo, hi, nan } = self.range();
        write!(text, "{lo}..={hi}{}", if nan { " or none" } else { "" })
    }
}

impl<F: Float> Add for Unknown<F> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.with(Op::Add, other)
    }
}
impl<F: Float> Sub for Unknown<F> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.with(Op::Sub, other)
    }
}
impl<F: Float> Mul for Unknown<F> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        self.with(Op::Mul, other)
    }
}
impl<F: Float> Neg for Unknown<F> {
    type Output = Self;
    fn neg(self) -> Self {
        self.of_one(Op::Neg)
    }
}

impl<F: Float> PartialEq for Unknown<F> {
    fn eq(&self, other: &Self) -> bool {
        graph::equal::<F>(self.place, other.place)
    }
}

impl<F: Float> PartialOrd for Unknown<F> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        if self < other {
            Some(Ordering::Less)
        } else if self > other {
            Some(Ordering::Greater)
        } else {
            (self == other).then_some(Ordering::Equal)
        }
    }
    fn lt(&self, other: &Self) -> bool {
        graph::less::<F>(self.place, other.place, true)
    }
    fn le(&self, other: &Self) -> bool {
        graph::less::<F>(self.place, other.place, false)
    }
    fn gt(&self, other: &Self) -> bool {
        other < self
    }
    fn ge(&self, other: &Self) -> bool {
        other <= self
    }
}

impl<F: Float> Scalar for Unknown<F> {
    type Counter = Unknown<f64>;
    const NAME: &'static str = F::NAME_OF_RANGES;
    const ZERO: Self = Self::at(graph::ZERO);
    const ONE: Self = Self::at(graph::ONE);

    fn from_f64(value: f64) -> Self {
        Self::at(graph::constant(F::from_f64(value).to_f64()))
    }
    /// The number, if it is one alone. Otherwise 0, and what is proved from there is not: it is noted.
    fn to_f64(self) -> f64 {
        graph::taken_out(self.place)
    }
    /// While a peer is built, this number; in its ticks, any whole number, whatever counts are.
    fn from_i32(value: i32) -> Self {
        Self::at(graph::whole::<F>(value))
    }
    /// Rounds the number that [`Unknown::to_f64`] gives.
    fn round_to_i32(self) -> i32 {
        F::from_f64(self.to_f64()).round_to_i32()
    }
    /// Whole numbers stand for any: so of what is left all is there that it may be.
    fn apart(self, _: i32, _: i32) -> (i32, Self) {
        (0, self - Self::from_i32(0))
    }
    /// Both ends, one after the other: a code decides about faults and nothing else. What lies between is noted.
    fn to_code(self) -> i16 {
        graph::code::<F>(self.place) as i16
    }
    fn to_counter(self) -> Unknown<f64> {
        Unknown::at(graph::compute::<f64>(Op::ToCounter, self.place, self.place))
    }
    fn of_counter(counter: Unknown<f64>) -> Self {
        Self::at(graph::compute::<F>(Op::OfCounter, counter.place, counter.place))
    }
    fn is_finite(self) -> bool {
        graph::is_finite::<F>(self.place)
    }
    /// Of the place, which is the number.
    fn bits(self) -> u64 {
        u64::from(self.place)
    }
    fn sqrt(self) -> Self {
        self.of_one(Op::Sqrt)
    }
    fn sin_cos(self) -> (Self, Self) {
        self.angle(F::sin_cos).unwrap_or_else(|| (self.of_one(Op::Sin), self.of_one(Op::Cos)))
    }
    /// Anything, unless it is one number: far from 0 the approximation is none.
    fn sin_cos_fast(self) -> (Self, Self) {
        self.angle(F::sin_cos_fast).unwrap_or_else(|| (Self::any(), Self::any()))
    }
    fn ratio(self, divisor: Self) -> Self {
        self.with(Op::Ratio, divisor)
    }
    fn over(self, divisor: Self) -> Self {
        self.with(Op::Over, divisor)
    }
    fn abs(self) -> Self {
        self.of_one(Op::Abs)
    }
    fn limit(self, bound: Self) -> Self {
        self.with(Op::Limit, bound)
    }
    /// Either: which of them does not tell anything.
    fn if_between(self, _: Self, _: Self, other: Self) -> Self {
        Self::within(self.range().or(other.range()))
    }
    fn max(self, other: Self) -> Self {
        self.with(Op::Max, other)
    }
    fn min(self, other: Self) -> Self {
        self.with(Op::Min, other)
    }
}
