//! Lanes: one number for each of [`LANES`] scenes, as one number type of a peer.
//!
//! Every operation is that of the type alone, lane by lane, so that the bits are, too. **Where the program asks one question and
//! the lanes have different answers** (a comparison; a number taken out of its type), the answer is that of most lanes, and the others
//! have left ([`lanes_left`]): what they hold from then on means nothing. So core's own lines run, whatever they branch on.
//!
//! **Where lanes come from**: what `build()` makes of settings goes through [`Scalar::from_f64`]. `recorded` notes these numbers for
//! one scene; `played` builds once more and hands out what was noted, to every lane its own. Both, and who has left, are of one thread.

use std::array::from_fn;
use std::cell::{Cell, RefCell};
use std::cmp::Ordering;
use std::ops::{Add, Mul, Neg, Sub};

use cohold_core::num::Scalar;
use wide::f64x8;

use crate::measure::Figure;

/// Number of scenes that are stepped side by side, one in each lane.
pub const LANES: usize = 16;
/// Every lane, as a bit mask.
pub(super) const ALL: u32 = (1 << LANES) - 1;

/// The source of the numbers that [`Scalar::from_f64`] makes.
enum ConstantSource {
    /// What it is given, for every lane.
    Off,
    /// The argument, for every lane; it is recorded.
    Recording(Vec<f64>),
    /// What was noted for each lane, and how much of it was handed out.
    Playing(Vec<Vec<f64>>, usize),
}

thread_local! {
    static LEFT: Cell<u32> = const { Cell::new(0) };
    static SHOWN: Cell<usize> = const { Cell::new(0) };
    static SOURCE: RefCell<ConstantSource> = const { RefCell::new(ConstantSource::Off) };
}

/// Lanes that have left since [`super::Pairs::new`], as a bit mask: their numbers mean nothing any more.
pub fn lanes_left() -> u32 {
    LEFT.get()
}

/// All lanes are there.
pub(super) fn nobody_left() {
    LEFT.set(0);
}

/// These lanes leave, too.
pub(super) fn leave(lanes: u32) {
    LEFT.set(LEFT.get() | lanes & ALL);
}

/// From now on the lane whose bits numbers have.
pub(super) fn show(lane: usize) {
    SHOWN.set(lane);
}

/// Builds something for one scene, and notes its numbers.
pub(super) fn recorded<T>(build: impl FnOnce() -> T) -> (T, Vec<f64>) {
    SOURCE.set(ConstantSource::Recording(Vec::new()));
    let built = build();
    let ConstantSource::Recording(numbers) = SOURCE.replace(ConstantSource::Off) else { return (built, Vec::new()) };
    (built, numbers)
}

/// Builds the same with the numbers of every lane.
pub(super) fn played<T>(numbers: Vec<Vec<f64>>, build: impl FnOnce() -> T) -> T {
    SOURCE.set(ConstantSource::Playing(numbers, 0));
    let built = build();
    SOURCE.set(ConstantSource::Off);
    built
}

/// The number of each lane that `from_f64` makes of this one.
#[inline(never)]
fn numbers(value: f64) -> [f64; LANES] {
    SOURCE.with_borrow_mut(|source| match source {
        ConstantSource::Off => [value; LANES],
        ConstantSource::Recording(noted) => {
            noted.push(value);
            [value; LANES]
        }
        ConstantSource::Playing(noted, at) => {
            let now = *at;
            *at += 1;
            // Where a scene has fewer it is not built alike, which its configuration will tell.
            from_fn(|lane| noted[lane].get(now).copied().unwrap_or(value))
        }
    })
}

/// The answer of most of those that are there; the others leave.
#[cold]
#[inline(never)]
fn disagreed(yes: u32) -> bool {
    let there = ALL & !LEFT.get();
    let most = 2 * (yes & there).count_ones() >= there.count_ones();
    leave(if most { !yes } else { yes });
    most
}

/// One answer of all lanes.
#[inline(always)]
fn decide(yes: u32) -> bool {
    if yes == ALL {
        true
    } else if yes == 0 {
        false
    } else {
        disagreed(yes)
    }
}

/// One value of all lanes: that of the first that is there; those that differ leave.
fn agree<T: Copy + PartialEq>(of: impl Fn(usize) -> T) -> T {
    let first = (!LEFT.get()).trailing_zeros() as usize % LANES;
    let value = of(first);
    leave((0..LANES).filter(|lane| of(*lane) != value).map(|lane| 1 << lane).sum());
    value
}

/// `f64` in each lane.
#[derive(Clone, Copy, Debug, Default)]
pub struct F64s([f64x8; 2]);

impl F64s {
    /// This number in every lane.
    #[inline(always)]
    pub const fn splat(value: f64) -> Self {
        Self([f64x8::splat(value); 2])
    }

    /// A number for each lane.
    #[inline(always)]
    pub fn of(mut lane: impl FnMut(usize) -> f64) -> Self {
        Self(from_fn(|at| f64x8::new(from_fn(|within| lane(at * 8 + within)))))
    }

    /// The number of each lane.
    #[inline(always)]
    pub fn lanes(self) -> [f64; LANES] {
        let vectors = self.0.map(|vector| vector.to_array());
        from_fn(|lane| vectors[lane / 8][lane % 8])
    }

    #[inline(always)]
    fn each(self, one: impl Fn(f64x8) -> f64x8) -> Self {
        Self(self.0.map(one))
    }

    #[inline(always)]
    fn with(self, other: Self, one: impl Fn(f64x8, f64x8) -> f64x8) -> Self {
        Self(from_fn(|at| one(self.0[at], other.0[at])))
    }

    /// Where the masks of a comparison are set, as bits.
    #[inline(always)]
    fn bits_of(masks: Self) -> u32 {
        let bits = |(at, mask): (usize, &f64x8)| mask.to_bitmask() << (at * 8);
        masks.0.iter().enumerate().map(bits).fold(0, |all, some| all | some)
    }

    #[inline(always)]
    fn choose(masks: Self, yes: Self, no: Self) -> Self {
        Self(from_fn(|at| masks.0[at].select(yes.0[at], no.0[at])))
    }
}

macro_rules! computed {
    ($Op:ident $op:ident $sign:tt) => {
        impl $Op for F64s {
            type Output = Self;
            #[inline(always)]
            fn $op(self, other: Self) -> Self {
                self.with(other, |a, b| a $sign b)
            }
        }
    };
}
computed!(Add add +);
computed!(Sub sub -);
computed!(Mul mul *);

impl Neg for F64s {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.each(|a| -a)
    }
}

macro_rules! compared {
    ($($name:ident $of_lanes:ident),+) => {$(
        #[inline(always)]
        fn $name(&self, other: &Self) -> bool {
            decide(Self::bits_of(self.with(*other, |a, b| a.$of_lanes(b))))
        }
    )+};
}

impl PartialEq for F64s {
    compared! { eq simd_eq }
}
impl PartialOrd for F64s {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        let (these, those) = (self.lanes(), other.lanes());
        agree(|lane| these[lane].partial_cmp(&those[lane]))
    }
    compared! { lt simd_lt, le simd_le, gt simd_gt, ge simd_ge }
}

impl Scalar for F64s {
    type Counter = F64s;
    const NAME: &'static str = f64::NAME;
    const ZERO: Self = Self::splat(0.0);
    const ONE: Self = Self::splat(1.0);
    #[inline]
    fn from_f64(value: f64) -> Self {
        let numbers = numbers(value);
        Self::of(|lane| numbers[lane])
    }
    fn to_f64(self) -> f64 {
        f64::from_bits(agree(|lane| self.lanes()[lane].to_bits()))
    }
    #[inline(always)]
    fn from_i32(value: i32) -> Self {
        Self::splat(value.into())
    }
    fn round_to_i32(self) -> i32 {
        agree(|lane| Scalar::round_to_i32(self.lanes()[lane]))
    }
    /// None: nothing that codes drive is stepped in lanes.
    #[inline(always)]
    fn to_code(self) -> i16 {
        0
    }
    #[inline(always)]
    fn to_counter(self) -> F64s {
        self
    }
    #[inline(always)]
    fn of_counter(counter: F64s) -> Self {
        counter
    }
    #[inline(always)]
    fn is_finite(self) -> bool {
        let limit = f64x8::splat(f64::INFINITY);
        decide(Self::bits_of(self.each(|a| a.abs().simd_lt(limit))))
    }
    /// Of the lane that is shown.
    fn bits(self) -> u64 {
        Scalar::bits(self.lanes()[SHOWN.get()])
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::choose(self.each(|a| a.simd_gt(f64x8::ZERO)), self.each(|a| a.sqrt()), Self::ZERO)
    }
    fn sin_cos(self) -> (Self, Self) {
        let both = self.lanes().map(Scalar::sin_cos);
        (Self::of(|lane| both[lane].0), Self::of(|lane| both[lane].1))
    }
    fn sin_cos_fast(self) -> (Self, Self) {
        let both = self.lanes().map(Scalar::sin_cos_fast);
        (Self::of(|lane| both[lane].0), Self::of(|lane| both[lane].1))
    }
    #[inline(always)]
    fn ratio(self, divisor: Self) -> Self {
        let nothing = divisor.each(|b| b.simd_eq(f64x8::ZERO));
        Self::choose(nothing, Self::ZERO, self.with(divisor, |a, b| a / b))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.each(|a| a.abs())
    }
    #[inline(always)]
    fn limit(self, bound: Self) -> Self {
        let low = Self::choose(self.with(bound, |a, b| a.simd_lt(-b)), -bound, Self::ZERO);
        let high = Self::choose(self.with(bound, |a, b| a.simd_gt(b)), bound, low);
        Self::choose(self.with(bound, |a, b| a.abs().simd_le(b)), self, high)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::choose(self.with(other, |a, b| a.simd_gt(b)), self, other)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::choose(self.with(other, |a, b| a.simd_lt(b)), self, other)
    }
}

impl F64s {
    /// One number in these lanes, the other in the rest.
    #[inline(always)]
    pub(super) fn chosen(lanes: u32, yes: Self, no: Self) -> Self {
        let (yes, no) = (yes.lanes(), no.lanes());
        Self::of(|lane| if lanes >> lane & 1 == 1 { yes[lane] } else { no[lane] })
    }
    /// The number of one lane.
    pub(crate) fn lane(self, lane: usize) -> f64 {
        self.lanes()[lane]
    }
}

impl Figure for F64s {
    const HALF: Self = Self::splat(0.5);
    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        let other = Self::choose(other.with(other, |a, b| a.simd_eq(b)), other, self);
        Self::choose(self.with(other, |a, b| a.simd_gt(b)), self, other)
    }
    #[inline(always)]
    fn or_infinite(self) -> Self {
        let infinite = Self::splat(f64::INFINITY);
        Self::choose(self.with(infinite, |a, b| a.abs().simd_lt(b)), self, infinite)
    }
    #[inline(always)]
    fn root(self) -> Self {
        self.each(|a| a.sqrt())
    }
}
