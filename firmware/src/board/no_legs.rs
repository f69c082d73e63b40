//! What stands in for the legs of bridges where a motor has a controller of its own: the timer has nothing at its outputs, and is there for what
//! breaks it.

/// The channels of the timer that are legs: there are none.
pub(super) const CHANNELS: core::ops::Range<usize> = 0..0;

/// No pins.
pub(crate) struct Legs;

impl Legs {
    pub(super) fn connect(self) {}
}
