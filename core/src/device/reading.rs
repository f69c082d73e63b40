//! What a device says about where it is.

use crate::num::Motion;

/// Most axes, and joints, that a peer has.
pub const AXES: usize = 2;

/// Raw value of a timer in encoder mode; wraps modulo 2¹⁶.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts(pub u16);

/// What a device says about where it is, once per tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading<S> {
    /// Raw counts of every joint's encoder: a real device, or a simulated one down to its encoders.
    Counts([Counts; AXES]),
    /// Position (m) and velocity (m/s) of every axis: a simulated device, or one that computes them itself.
    Exact([Motion<S>; AXES]),
}
