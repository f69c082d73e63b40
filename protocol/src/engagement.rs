//! Engagement: how far the coordination may act, from how long the other peer has been silent.
//!
//! Degradation by silence, in packet periods since the last flow was taken:
//!
//! | silent for | rung | level |
//! |---|---|---|
//! | up to 3 | [`Rung::Engaged`] | rises by 1/12 a period, to 1; a missing packet is the ledger's business |
//! | 3 to 12 | [`Rung::Fading`] | falls by 1/9 a period, so that it is 0 at 12 |
//! | 12 and more | [`Rung::Disengaged`] | 0; local rendering goes on |
//!
//! Silence is a time: where packets come more often than every 8 ms silence is still counted in 8 ms, and where the peers are to
//! be apart only after longer than 12 packet periods ([`crate::link::Link::disengage_after`]), in a twelfth of that.
//!
//! It is for a caller whose coordination knows nothing of silence. One that fades its packets itself, counted in packets as its
//! analysis needs them, takes the notices (a session began, ended) and leaves the level alone: two in a row fade twice.
//!
//! The level starts from 0 whenever the peers come together. It changes with time only, never with what was in a packet,
//! so it has no jumps but the one to 0 when a session ends. **Unit**: µs in, a factor from 0 to 1 out. Exact: counted in
//! whole 1/36 of a µs, the least that both 1/12 and 1/9 divide. Time that goes backwards counts as standing still.

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Rung {
    /// No flow, or none for long.
    #[default]
    Disengaged,
    /// Flow comes: the level rises to 1.
    Engaged,
    /// Flow stays away: the level falls to 0.
    Fading,
}

/// Packet periods of silence before the coordination fades.
pub(crate) const FADE_AFTER: u32 = 3;
/// Packet periods of silence before the peers are apart.
pub(crate) const DISENGAGE_AFTER: u32 = 12;
/// The shortest period that silence is counted in, µs.
const SHORTEST_PERIOD_US: u32 = 8_000;
/// Packet periods from 0 to full engagement.
pub(crate) const RISE: u32 = 12;

const LEVELS: u32 = RISE * (DISENGAGE_AFTER - FADE_AFTER) / 3;
const RISE_STEP: u64 = (LEVELS / RISE) as u64;
const FADE_STEP: u64 = (LEVELS / (DISENGAGE_AFTER - FADE_AFTER)) as u64;
const _: () = assert!(LEVELS.is_multiple_of(RISE) && LEVELS.is_multiple_of(DISENGAGE_AFTER - FADE_AFTER));

#[derive(Clone, Copy, Debug)]
pub(crate) struct Engagement {
    period_us: u64,
    heard_us: Option<u64>,
    updated_us: u64,
    /// From 0 to 36 packet periods.
    level: u64,
}

impl Engagement {
    /// Apart, for flow that comes each `period_us`; the peers are to be apart after `disengage_after_us` of silence, if that is longer.
    pub(crate) fn new(period_us: u32, disengage_after_us: u32) -> Self {
        let period_us = period_us.max(SHORTEST_PERIOD_US).max(disengage_after_us.div_ceil(DISENGAGE_AFTER));
        Self { period_us: u64::from(period_us), heard_us: None, updated_us: 0, level: 0 }
    }

    /// Silence after which the peers are apart, µs.
    pub(crate) fn disengage_after_us(&self) -> u64 {
        self.periods(DISENGAGE_AFTER)
    }

    /// The peers part: level 0 until flow comes again.
    pub(crate) fn part(&mut self) {
        self.heard_us = None;
        self.level = 0;
    }

    /// Flow was taken. Call [`Engagement::update`] with the same `now` before.
    pub(crate) fn hear(&mut self, now: u64) {
        if self.heard_us.is_none() {
            self.level = 0;
            self.updated_us = now;
        }
        self.heard_us = Some(now);
    }

    pub(crate) fn update(&mut self, now: u64) {
        let Some(heard) = self.heard_us else { return };
        let fade = heard.saturating_add(self.periods(FADE_AFTER));
        let disengaged = heard.saturating_add(self.periods(DISENGAGE_AFTER));
        let until_fade = now.min(fade).saturating_sub(self.updated_us);
        let after_fade = now.saturating_sub(fade.max(self.updated_us));
        self.level = self.level.saturating_add(until_fade.saturating_mul(RISE_STEP)).min(self.full());
        self.level = self.level.saturating_sub(after_fade.saturating_mul(FADE_STEP));
        self.updated_us = self.updated_us.max(now);
        if now >= disengaged {
            self.part();
        }
    }

    fn periods(&self, count: u32) -> u64 {
        self.period_us.saturating_mul(u64::from(count))
    }

    fn full(&self) -> u64 {
        self.periods(LEVELS)
    }

    /// How far the coordination is degraded, as of the last update.
    pub(crate) fn rung(&self) -> Rung {
        match self.heard_us {
            None => Rung::Disengaged,
            Some(heard) if self.updated_us.saturating_sub(heard) > self.periods(FADE_AFTER) => Rung::Fading,
            Some(_) => Rung::Engaged,
        }
    }

    /// How far the coordination may act, 0 to 1, as of the last update.
    pub(crate) fn level(&self) -> f32 {
        self.level as f32 / self.full() as f32
    }
}
