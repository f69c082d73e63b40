//! What a peer's state is made of: motion, sums of many small terms, and how it is visited as a vector, which the
//! stability analysis sets to unit states and over which a state hash runs.
//!
//! Sums are compensated (Kahan 1965): a position is a sum of a thousand steps a second. In f32 each step is rounded to about 3e-8 m
//! at 0.3 m, and ten hours of that walk away by micrometres; with the part that did not fit carried to the next step, the error stays
//! at one rounding, however many the terms. Needs plain IEEE arithmetic in source order, which is what this crate compiles to.

use crate::num::Scalar;

/// A state whose numbers can be visited, always in the same order.
pub trait StateVector<S> {
    /// Calls `each` once for every number in the state.
    fn visit(&mut self, each: &mut impl FnMut(&mut S));
}

/// Implements [`StateVector`](crate::num::StateVector) for a struct: its generics, its type, and the fields that are visited, in this order.
///
/// ```
/// use cohold_core::{num::{Motion, Scalar}, visited};
///
/// struct Predicted<S> {
///     desired: Motion<S>,
///     ahead: S,
///     packets: u32,
/// }
/// visited!([S: Scalar] Predicted<S> { desired, ahead });
/// ```
#[macro_export]
macro_rules! visited {
    ([$($generics:tt)*] $Type:ty { $($($field:ident).+),* }) => {
        impl<$($generics)*> $crate::num::StateVector<S> for $Type {
            #[inline]
            fn visit(&mut self, _each: &mut impl FnMut(&mut S)) {
                $( $crate::num::StateVector::visit(&mut self.$($field).+, _each); )*
            }
        }
    };
}

visited!([S] () {});

impl<S: Scalar> StateVector<S> for S {
    #[inline]
    fn visit(&mut self, each: &mut impl FnMut(&mut S)) {
        each(self);
    }
}

impl<S, A: StateVector<S>, B: StateVector<S>> StateVector<S> for (A, B) {
    #[inline]
    fn visit(&mut self, each: &mut impl FnMut(&mut S)) {
        self.0.visit(each);
        self.1.visit(each);
    }
}

impl<S, T: StateVector<S>, const N: usize> StateVector<S> for [T; N] {
    #[inline]
    fn visit(&mut self, each: &mut impl FnMut(&mut S)) {
        for item in self {
            item.visit(each);
        }
    }
}

/// Visits a number that is kept in another type than the peer computes in; untouched unless it is changed.
pub fn visit_counter<S: Scalar>(number: &mut S::Counter, each: &mut impl FnMut(&mut S)) {
    let before = S::of_counter(*number);
    let mut visited = before;
    each(&mut visited);
    if visited.bits() != before.bits() {
        *number = visited.to_counter();
    }
}

/// Visits what a sum is so far; one that is changed begins anew from there.
pub fn visit_sum<S: Scalar>(sum: &mut Sum<S::Counter>, each: &mut impl FnMut(&mut S)) {
    let before = sum.total();
    let mut visited = before;
    visit_counter::<S>(&mut visited, each);
    if visited != before {
        *sum = Sum::from(visited);
    }
}

/// Position (m) and velocity (m/s) along one axis; for a joint that turns, rad and rad/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion<S> {
    /// Position, m; of a joint that turns, rad.
    pub position: S,
    /// Velocity, m/s; of a joint that turns, rad/s.
    pub velocity: S,
}

impl<S> Motion<S> {
    /// At `position` (m), with `velocity` (m/s).
    #[inline(always)]
    pub const fn new(position: S, velocity: S) -> Self {
        Self { position, velocity }
    }
}

impl<S: Scalar> Motion<S> {
    /// At rest at the origin.
    pub const REST: Self = Self::new(S::ZERO, S::ZERO);

    /// At rest at `position` (m).
    pub fn at(position: S) -> Self {
        Self::new(position, S::ZERO)
    }

    /// Whether position and velocity are finite.
    #[inline]
    pub fn is_finite(self) -> bool {
        // One test for two: nothing times a number is nothing, times anything else no number.
        S::ZERO * self.position + S::ZERO * self.velocity == S::ZERO
    }
}

visited!([S: Scalar] Motion<S> { position, velocity });

/// The rounding error of a sum that is kept elsewhere, made good with the next term.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Carry<S>(S);

impl<S: Scalar> Carry<S> {
    /// `total + term`; what rounding leaves over goes into the next sum.
    #[inline]
    pub fn add(&mut self, total: S, term: S) -> S {
        let term = term - self.0;
        let sum = total + term;
        self.0 = (sum - total) - term;
        sum
    }
}

/// A running sum with compensated rounding: what a term loses is carried to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sum<S> {
    total: S,
    carry: Carry<S>,
}

impl<S: Scalar> Sum<S> {
    /// Adds one term, carrying what rounding loses.
    #[inline]
    pub fn add(&mut self, term: S) {
        self.total = self.carry.add(self.total, term);
    }

    /// The sum so far.
    pub fn total(&self) -> S {
        self.total
    }

    /// A sum that starts at `total`.
    pub fn from(total: S) -> Self {
        Self { total, carry: Carry::default() }
    }
}
