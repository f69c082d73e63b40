//! Collaborative environment: one at a time edits an object (Buttolo et al. 1997, §3.2).
//!
//! | module | who says whose turn it is | the one true copy is | without which |
//! |---|---|---|---|
//! | [`lock`] | a central server, first come first served | at the server | nothing goes on while the server is away |
//! | [`ring`] | the token, which goes round | with a majority of the members | nothing goes on without a majority |
//!
//! In both everybody renders a local copy at 1 kHz and may push it about; only what the owner publishes is copied.
//!
//! **Never two owners, never a lost update**, whatever the network does and whoever crashes, under two assumptions:
//!
//! 1. Two clocks run at the same rate to within [`Lease::MAX_DRIFT_PPM`] (quartz: 100 ppm). Times are never compared between
//!    peers, only durations; delay may be anything.
//! 2. What a machine calls its `Record` is stored before anything that it said afterwards is sent, and is there again after
//!    a crash: a file on a PC, backup memory on a board. A client of the lock needs no record.
//!
//! In a network without a bound on delay nobody can have both safety and progress always. Here safety never waits for
//! anything, progress does: it needs the server, or a majority that hear each other.
//!
//! A *lost update* is one that its author was notified is published and that a later state does not build on.

mod lease;
pub mod lock;
pub mod ring;

pub use lease::{Approach, Lease, OutOfRange, Wish};

/// What an object is, as its owner left it: 24 bytes for the application to fill (position and velocity, three `f32` each).
/// A shape that needs more travels as a scene, and this names its version.
pub type Value = [u8; 24];

/// Only the owner can publish.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("only the owner of the object can publish it, and this peer is not, or no longer")]
pub struct NotOwner;
