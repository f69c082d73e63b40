//! The lifted, or monodromy, matrix: what one packet period makes of the state of two peers.
//!
//! A pair of peers repeats itself every M ticks, so its stability is one matrix: state just before an exchange → state
//! just before the next (cooperation paper §4; THEORY §3). `tests/oracle` builds it once more, from the paper's algebra and from nothing in common:
//!
//! | module | builds it by |
//! |---|---|
//! | [`driven`] | running `cohold_core::peer::{exchange, tick}`, the code that flies, on unit states |
//! | [`closing`] | joining what peers answer through the network's queues, for the former |
//! | [`delay`] | counting the packets on their way |
//! | [`prune`] | leaving out states that nothing depends on, or that are always zero |
//! | [`kicked`] | running the pair, where no packet period is like the next |
//! | [`pair`] | which of these a scene falls apart into |
//! | [`rest`] | dividing rest modes out by their eigenvectors |
//!
//! **Symmetry.** Two peers with the same settings, on a network that is the same both ways, fall apart into their sum and
//! their difference: each is *one* peer that hears its own packets, as they are or with the sign turned. Two eigenproblems
//! of half the size cost a quarter of one.

pub(crate) mod closing;
pub(crate) mod delay;
pub(crate) mod driven;
pub(crate) mod kicked;
pub(crate) mod pair;
pub(crate) mod prune;
pub(crate) mod rest;

pub use crate::matrix::{Matrix, apply};

/// A lifted matrix with the rest modes it must have.
#[derive(Clone, Debug, Default)]
pub struct Lifted {
    /// State before an exchange → state before the next one.
    pub matrix: Matrix,
    /// Directions that stay as they are: eigenvectors with eigenvalue 1, linearly independent.
    pub rest_modes: Vec<Vec<f64>>,
}
