//! An input read as a script: what happens next, to whom, and how much of it.

/// What is left of an input. At its end every number is 0.
pub(super) struct Script<'a>(pub(super) &'a [u8]);

impl<'a> Script<'a> {
    /// Whether there is anything left.
    pub(super) fn goes_on(&self) -> bool {
        !self.0.is_empty()
    }

    /// The next byte of the script; 0 when it is used up.
    pub(super) fn byte(&mut self) -> u8 {
        self.bytes(1).first().copied().unwrap_or(0)
    }

    /// The next number below `end`, from one byte.
    pub(super) fn below(&mut self, end: usize) -> usize {
        usize::from(self.byte()) % end
    }

    /// The next 16 bits.
    pub(super) fn half(&mut self) -> u16 {
        u16::from(self.byte()) | u16::from(self.byte()) << 8
    }

    /// The next `count` bytes, or as many as there are.
    pub(super) fn bytes(&mut self, count: usize) -> &'a [u8] {
        let (taken, rest) = self.0.split_at(count.min(self.0.len()));
        self.0 = rest;
        taken
    }

    /// A time from 0 to 2 s, small ones more often, µs.
    pub(super) fn time_us(&mut self) -> u64 {
        let byte = u64::from(self.byte());
        (byte % 32) << (byte / 32 * 2 + 2)
    }
}
