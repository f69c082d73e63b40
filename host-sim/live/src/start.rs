//! Start: when the two ends of a line begin to move.
//!
//! Waves carry changes and no places, so what a copy moves while only one end of its line lives is lost for good. Therefore nobody's hand
//! moves before **both ends** are live: their motors on and their coordination complete, as each says in its flow (`fading` is off). They
//! begin at an instant that both know: so long after the later of the two first said so, by the seal's time and the common clock.
//! A hub says so to all its peers at once, when all their lines are live, so that all begin together.
//!
//! **Limits**: the ends agree as exactly as the clock knows the offset, if the flow that first said so was not lost; otherwise one begins
//! some packet periods later, on a line that is live.

/// Delay from when both ends are live to when they begin to move, µs: no flow that is accepted is older, so both know in time.
pub const AFTER_US: u64 = 500_000;

/// When each end of a line became live, as one end knows it, µs of its own clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Start {
    own_us: Option<u64>,
    other_us: Option<u64>,
}

impl Start {
    /// Takes note of what this end announces at `now_us` (µs): `whole` if its coordination is complete, `engaged` if it
    /// acts at all. Once whole, the end stays live until it is no longer engaged.
    pub fn say(&mut self, now_us: u64, whole: bool, engaged: bool) {
        self.own_us = self.own_us.filter(|_| engaged).or(whole.then_some(now_us));
    }

    /// Takes note that the other end announced at `said_us` (µs) that it is live, or not.
    pub fn hear(&mut self, said_us: u64, live: bool) {
        self.other_us = live.then_some(self.other_us.unwrap_or(said_us));
    }

    /// Whether this end is live.
    pub fn says(&self) -> bool {
        self.own_us.is_some()
    }

    /// Time since which both ends are live, µs of this end's clock; `None` if they are not.
    pub fn both_us(&self) -> Option<u64> {
        self.own_us.zip(self.other_us).map(|(own, other)| own.max(other))
    }
}
