//! Replay window: every sequence number is taken once (RFC 6479).
//!
//! A ring of bits, one for each of the newest sequence numbers; when a newer one comes, the words it enters are cleared
//! instead of shifting anything. One word of the ring is always being filled, so that [`Window::REACH`] =
//! 256 − 32 = 224 numbers behind the newest are remembered, in whatever order they come; older ones are refused.
//!
//! **Invariant**: [`Window::check`] changes nothing, and [`Window::take`] is called only after the tag was found right,
//! so that nobody without the key can move the window. **Limit**: numbers from [`SEQUENCE_LIMIT`] on are refused.

use crate::error::Refusal;

/// The first sequence number that is never used: far below the wrap, further than a peer can count.
pub const SEQUENCE_LIMIT: u64 = u64::MAX - (1 << 14) + 1;

/// A window over the newest sequence numbers that remembers which of them were taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Window {
    /// One more than the newest number taken, 0 before the first.
    next: u64,
    bits: [u32; Self::WORDS],
}

impl Window {
    const WORD_BITS: u64 = u32::BITS as u64;
    const WORDS: usize = 8;
    /// How far behind the newest number a number is still remembered.
    pub const REACH: u64 = (Self::WORDS as u64 - 1) * Self::WORD_BITS;

    fn place(sequence: u64) -> (usize, u32) {
        let word = sequence / Self::WORD_BITS % Self::WORDS as u64;
        (word as usize, 1 << (sequence % Self::WORD_BITS))
    }

    /// Whether `sequence` could be taken; changes nothing.
    ///
    /// # Errors
    /// The number was taken before, is too old, or lies beyond the last number.
    pub fn check(&self, sequence: u64) -> Result<(), Refusal> {
        if sequence >= SEQUENCE_LIMIT {
            return Err(Refusal::BeyondLast);
        }
        if sequence >= self.next {
            return Ok(());
        }
        if self.next - sequence > Self::REACH + 1 {
            return Err(Refusal::TooOld);
        }
        let (word, bit) = Self::place(sequence);
        match self.bits.get(word) {
            Some(bits) if bits & bit == 0 => Ok(()),
            _ => Err(Refusal::Replayed),
        }
    }

    /// Takes `sequence`, whose datagram has been found authentic.
    ///
    /// # Errors
    /// The number was taken before, is too old, or lies beyond the last number.
    pub fn take(&mut self, sequence: u64) -> Result<(), Refusal> {
        self.check(sequence)?;
        if sequence >= self.next {
            // Words from the one after the newest number's up to this number's hold numbers of an earlier turn.
            let newest_word = self.next.saturating_sub(1) / Self::WORD_BITS;
            let entered = (sequence / Self::WORD_BITS).saturating_sub(newest_word).min(Self::WORDS as u64);
            for step in 1..=entered {
                let (word, _) = Self::place((newest_word + step) * Self::WORD_BITS);
                if let Some(bits) = self.bits.get_mut(word) {
                    *bits = 0;
                }
            }
            self.next = sequence + 1;
        }
        let (word, bit) = Self::place(sequence);
        if let Some(bits) = self.bits.get_mut(word) {
            *bits |= bit;
        }
        Ok(())
    }

    /// The newest number taken.
    pub fn newest(&self) -> Option<u64> {
        self.next.checked_sub(1)
    }
}
