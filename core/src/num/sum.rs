//! Sums of many small terms, with compensation (Kahan 1965).
//!
//! A position is a sum of a thousand steps a second. In f32 each step is rounded to about 3e-8 m at 0.3 m, and ten hours
//! of that walk away by micrometres; with the part that did not fit carried to the next step, the error stays at one
//! rounding, however many the terms. Needs plain IEEE arithmetic in source order, which is what this crate compiles to.

use crate::num::Scalar;

/// What did not fit into a sum that is kept elsewhere.
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

/// A running sum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sum<S> {
    total: S,
    carry: Carry<S>,
}

impl<S: Scalar> Sum<S> {
    /// Adds one term.
    #[inline]
    pub fn add(&mut self, term: S) {
        self.total = self.carry.add(self.total, term);
    }

    /// The sum.
    pub fn total(&self) -> S {
        self.total
    }
}
