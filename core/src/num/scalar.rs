//! The number types a peer computes in, and the only maths functions it may call.
//!
//! [`f32`] is for the board, [`f64`] for the analyser, [`Fixed`] (the crate `fixed`'s I32F32: range ±2³¹, step 2⁻³² ≈ 2.3e-10)
//! is for processors without an FPU. Results are the same bits on every machine: plain IEEE operations in source order,
//! no fused multiply-add, no platform maths; square root and trigonometry are pure Rust (`libm`).
//!
//! Every operation is total. Floats may give infinities or NaN, which [`crate::safety`] catches; [`Fixed`] saturates.

use core::fmt::Debug;
use core::ops::{Add, Mul, Neg, Sub};

use fixed::types::{I32F32, I64F64};

/// A number type the whole peer can be built on.
pub trait Scalar:
    Copy
    + Debug
    + Default
    + PartialEq
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + Send
    + Sync
    + 'static
{
    /// The type in which long sums are kept, which must hold more digits than this one: `f64`, or a lane of `f64` for each lane.
    type Counter: Scalar;
    /// Name for reports: `f32`, `f64`, `i32f32`.
    const NAME: &'static str;
    /// Zero, the additive identity.
    const ZERO: Self;
    /// One, the multiplicative identity.
    const ONE: Self;

    /// The nearest value; saturates where the type is bounded. For use in `build()`, not in the tick.
    fn from_f64(value: f64) -> Self;
    /// The value as `f64`: exact for `f32` and `f64`; [`Fixed`] rounds to 53 bits.
    fn to_f64(self) -> f64;
    /// The value of an integer: exact for `f64` and [`Fixed`]; `f32` rounds to 24 bits.
    fn from_i32(value: i32) -> Self;
    /// Nearest integer, saturating; NaN gives 0. Ties, and floats within one rounding of a tie, go away from zero.
    fn round_to_i32(self) -> i32;
    /// Two numbers that are told as one: how often `step` is in the value, `most` times at the most, and what is left.
    #[inline]
    fn apart(self, step: i32, most: i32) -> (i32, Self) {
        let times = (self.round_to_i32() / step).clamp(0, most);
        (times, self - Self::from_i32(step * times))
    }
    /// The nearest integer of a value within ±32767, as a motor's duty code.
    #[inline]
    fn to_code(self) -> i16 {
        self.round_to_i32() as i16
    }
    /// The nearest value of [`Scalar::Counter`]; rounds as [`Scalar::to_f64`] does.
    fn to_counter(self) -> Self::Counter;
    /// The value nearest to `counter`, rounded as [`Scalar::from_f64`] does, in each lane by itself.
    fn of_counter(counter: Self::Counter) -> Self;
    /// Whether the value is neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// The bits of the value, equal where two values are the same, for state hashes.
    fn bits(self) -> u64;
    /// Square root, correctly rounded, [`Fixed`] to a step; a negative argument gives 0.
    fn sqrt(self) -> Self;
    /// Sine and cosine of an angle in rad: error < 1 ulp, of `f32` up to 4·10⁸ rad and no number beyond; [`Fixed`] < 2⁻³¹ up to 2²¹ rad.
    fn sin_cos(self) -> (Self, Self);
    /// Sine and cosine of an angle in rad; for `f32` by `micromath`, with an error ≤ 1.1e-3 at a fraction of the cost.
    fn sin_cos_fast(self) -> (Self, Self) {
        self.sin_cos()
    }
    /// Quotient; 0 where the divisor is 0, so that it is total.
    fn ratio(self, divisor: Self) -> Self;
    /// Quotient by a divisor that is known not to be 0.
    #[inline]
    fn over(self, divisor: Self) -> Self {
        self.ratio(divisor)
    }

    /// Absolute value; NaN stays NaN.
    #[inline]
    fn abs(self) -> Self {
        if self < Self::ZERO { -self } else { self }
    }
    /// The value held within `±bound`; NaN gives 0, so that what comes out is always finite for a finite bound.
    #[inline]
    fn limit(self, bound: Self) -> Self {
        // What is usual first: nothing to limit.
        if self.abs() <= bound {
            self
        } else if self > bound {
            bound
        } else if self < -bound {
            -bound
        } else {
            Self::ZERO
        }
    }
    /// The value if it lies between these two, ends included, and `other` if not, or if one of them is NaN.
    #[inline]
    fn if_between(self, lowest: Self, highest: Self, other: Self) -> Self {
        if self >= lowest && self <= highest { self } else { other }
    }
    /// The larger of the two; `other` where `self` is NaN.
    #[inline]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    /// The smaller of the two; `other` where `self` is NaN.
    #[inline]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
}

macro_rules! float_scalar {
    ($float:ident, $name:literal, $sqrt:path, $sincos:path { $($fast:item)* }) => {
        impl Scalar for $float {
            type Counter = f64;
            const NAME: &'static str = $name;
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            #[inline]
            fn from_f64(value: f64) -> Self {
                value as $float
            }
            #[inline]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline]
            fn to_counter(self) -> f64 {
                f64::from(self)
            }
            #[inline]
            fn of_counter(counter: f64) -> Self {
                counter as $float
            }
            #[inline]
            fn from_i32(value: i32) -> Self {
                value as $float
            }
            #[inline]
            fn round_to_i32(self) -> i32 {
                // libm::round truncates this sum; so does the cast, in one instruction.
                (self + (0.5 - 0.25 * $float::EPSILON).copysign(self)) as i32
            }
            #[inline]
            fn abs(self) -> Self {
                $float::abs(self)
            }
            #[inline]
            fn is_finite(self) -> bool {
                $float::is_finite(self)
            }
            #[inline]
            fn bits(self) -> u64 {
                u64::from(self.to_bits())
            }
            #[inline]
            fn sqrt(self) -> Self {
                if self > 0.0 { $sqrt(self) } else { 0.0 }
            }
            #[inline]
            fn sin_cos(self) -> (Self, Self) {
                $sincos(self)
            }
            #[inline]
            fn ratio(self, divisor: Self) -> Self {
                if divisor == 0.0 { 0.0 } else { self / divisor }
            }
            #[inline]
            fn over(self, divisor: Self) -> Self {
                self / divisor
            }
            $($fast)*
        }
    };
}

float_scalar!(f32, "f32", super::sqrt::sqrt, super::sin_cos::sin_cos {
    #[inline]
    fn sin_cos_fast(self) -> (Self, Self) {
        micromath::F32Ext::sin_cos(self)
    }
});
float_scalar!(f64, "f64", libm::sqrt, libm::sincos {});

/// [`I32F32`], saturating in every operation, with products to the nearest step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Fixed(I32F32);

impl Fixed {
    /// The number of so many steps of 2⁻³².
    #[inline]
    pub const fn from_bits(steps: i64) -> Self {
        Self(I32F32::from_bits(steps))
    }
}

macro_rules! saturating {
    ($Op:ident, $op:ident, $saturating:ident) => {
        impl $Op for Fixed {
            type Output = Self;
            #[inline]
            fn $op(self, other: Self) -> Self {
                Self(self.0.$saturating(other.0))
            }
        }
    };
}

saturating!(Add, add, saturating_add);
saturating!(Sub, sub, saturating_sub);

impl Mul for Fixed {
    type Output = Self;
    // A processor of 32 bits takes some forty instructions for a product: too many to have them at every place.
    #[cfg_attr(target_pointer_width = "32", inline(never))]
    #[cfg_attr(target_pointer_width = "64", inline)]
    fn mul(self, other: Self) -> Self {
        // To the nearest step: with a bias of half a step each product, as the crate's own product has, positions would creep. Ties
        // go away from zero, so that (−x)·y is −(x·y): two peers that mirror each other do so bit for bit.
        let wide = self.0.wide_mul(other.0);
        let half = I64F64::from_bits((1 << 31) - i128::from(wide.is_negative()));
        Self(I32F32::saturating_from_num(wide + half))
    }
}
impl Neg for Fixed {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self(self.0.saturating_neg())
    }
}

impl Scalar for Fixed {
    type Counter = f64;
    const NAME: &'static str = "i32f32";
    const ZERO: Self = Self(I32F32::ZERO);
    const ONE: Self = Self(I32F32::ONE);
    #[cfg_attr(target_pointer_width = "32", inline(never))]
    #[cfg_attr(target_pointer_width = "64", inline)]
    fn from_f64(value: f64) -> Self {
        Self(if value.is_nan() { I32F32::ZERO } else { I32F32::saturating_from_num(value) })
    }
    #[cfg_attr(target_pointer_width = "32", inline(never))]
    #[cfg_attr(target_pointer_width = "64", inline)]
    fn to_f64(self) -> f64 {
        self.0.to_num()
    }
    #[inline]
    fn to_counter(self) -> f64 {
        self.to_f64()
    }
    #[inline]
    fn of_counter(counter: f64) -> Self {
        Self::from_f64(counter)
    }
    #[inline]
    fn from_i32(value: i32) -> Self {
        Self(value.into())
    }
    #[inline]
    fn round_to_i32(self) -> i32 {
        self.0.saturating_round().to_num()
    }
    #[inline]
    fn is_finite(self) -> bool {
        true
    }
    #[inline]
    fn bits(self) -> u64 {
        self.0.to_bits().cast_unsigned()
    }
    fn sqrt(self) -> Self {
        Self::from_f64(Scalar::sqrt(self.to_f64()))
    }
    fn sin_cos(self) -> (Self, Self) {
        let (sine, cosine) = Scalar::sin_cos(self.to_f64());
        (Self::from_f64(sine), Self::from_f64(cosine))
    }
    // A division of 128 bits is a call anyway.
    #[inline(never)]
    fn ratio(self, divisor: Self) -> Self {
        if divisor == Self::ZERO { divisor } else { Self(self.0.saturating_div(divisor.0)) }
    }
}
