//! Engagement: whether the peers are together, from how long the other one has been silent.
//!
//! In packet periods since the last flow was taken:
//!
//! | silent for | rung |
//! |---|---|
//! | up to 3 | [`Rung::Engaged`]: a missing packet is the ledger's business |
//! | 3 to 12 | [`Rung::Fading`] |
//! | 12 and more | [`Rung::Disengaged`]; local rendering goes on |
//!
//! Silence is a time: where packets come more often than every 8 ms silence is still counted in 8 ms, and where the peers are to
//! be apart only after longer than 12 packet periods ([`crate::link::Link::disengage_after`]), in a twelfth of that.
//!
//! A link says which rung it is on, and no more. How a force lets go of a peer that is silent, and takes hold again, is the business of who
//! has the force. Time that goes backwards counts as standing still.

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Rung {
    /// No flow, or none for long.
    #[default]
    Disengaged,
    /// Flow comes.
    Engaged,
    /// Flow stays away.
    Fading,
}

/// Packet periods of silence before the coordination fades.
pub(crate) const FADE_AFTER: u32 = 3;
/// Packet periods of silence before the peers are apart.
pub(crate) const DISENGAGE_AFTER: u32 = 12;
/// The shortest period that silence is counted in, µs.
const SHORTEST_PERIOD_US: u32 = 8_000;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Engagement {
    period_us: u64,
    heard_us: Option<u64>,
    updated_us: u64,
}

impl Engagement {
    /// Apart, for flow that comes each `period_us`; the peers are to be apart after `disengage_after_us` of silence, if that is longer.
    pub(crate) fn new(period_us: u32, disengage_after_us: u32) -> Self {
        let period_us = period_us.max(SHORTEST_PERIOD_US).max(disengage_after_us.div_ceil(DISENGAGE_AFTER));
        Self { period_us: u64::from(period_us), heard_us: None, updated_us: 0 }
    }

    /// Silence after which the peers are apart, µs.
    pub(crate) fn disengage_after_us(&self) -> u64 {
        self.periods(DISENGAGE_AFTER)
    }

    /// The peers part until flow comes again.
    pub(crate) fn part(&mut self) {
        self.heard_us = None;
    }

    /// Flow was taken. Call [`Engagement::update`] with the same `now` before.
    pub(crate) fn hear(&mut self, now: u64) {
        self.heard_us = Some(now);
    }

    pub(crate) fn update(&mut self, now: u64) {
        self.updated_us = self.updated_us.max(now);
        if self.heard_us.is_some_and(|heard| now >= heard.saturating_add(self.disengage_after_us())) {
            self.part();
        }
    }

    fn periods(&self, count: u32) -> u64 {
        self.period_us.saturating_mul(u64::from(count))
    }

    /// How long the other peer has been silent, as of the last update.
    pub(crate) fn rung(&self) -> Rung {
        match self.heard_us {
            None => Rung::Disengaged,
            Some(heard) if self.updated_us.saturating_sub(heard) > self.periods(FADE_AFTER) => Rung::Fading,
            Some(_) => Rung::Engaged,
        }
    }
}
