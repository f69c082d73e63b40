//! State as a vector: what the analyser needs to drive a peer on unit states, and what a state hash runs over.

use crate::num::Scalar;

/// A state whose numbers can be visited, always in the same order.
pub trait StateVector<S> {
    /// Calls `each` once for every number in the state.
    fn visit(&mut self, each: &mut impl FnMut(&mut S));
}

impl<S> StateVector<S> for () {
    fn visit(&mut self, _: &mut impl FnMut(&mut S)) {}
}

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
