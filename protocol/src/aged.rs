//! What was so at a time: it counts for so long, and is unknown after that.

use core::ops::Sub;

/// A value and when it was so: µs of the reader's clock, or a time of `std`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Aged<T, At = u64> {
    value: T,
    /// When it was so.
    pub at: At,
}

impl<T, At: Copy + PartialOrd + Sub<Output: PartialOrd>> Aged<T, At> {
    /// This was so then.
    pub const fn new(value: T, at: At) -> Self {
        Self { value, at }
    }

    /// The value, if it is no older than `most`. What is said to be of a time to come is of now.
    pub fn within(&self, now: At, most: At::Output) -> Option<&T> {
        (now <= self.at || now - self.at <= most).then_some(&self.value)
    }
}
