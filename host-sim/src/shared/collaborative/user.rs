//! A user at an object: comes near, edits as soon as it may, moves away; sometimes loses patience before.

use haptic_protocol::roles::collaborative::{Approach, Value, Wish};

use super::history::History;
use haptic_sim::rng::Rng;

/// How fast a hand comes and goes, m/s.
const SPEED_M_PER_S: f64 = 0.5;
/// Where it rests, away from the object, m.
const AWAY_M: f64 = 0.05;
/// Where it asks, and where it gives back.
const APPROACH: Approach = Approach { near_m: 0.02, far_m: 0.03 };
/// Longest edit, µs; of an impatient user, one in 8 takes six times as long.
pub const LONGEST_EDIT_US: u64 = 120_000;
/// Longer than a lease or a turn.
const STUBBORN: u64 = 6;

/// One user: this visit, and what the earlier ones came to.
#[derive(Clone, Debug)]
pub struct User {
    /// Turns toward the object at this time, µs.
    comes_us: u64,
    /// Turns away, done or not.
    goes_us: u64,
    /// How long it edits once it may.
    edit_us: u64,
    /// Since when it has been editing.
    editing_us: Option<u64>,
    /// Stays until it has edited.
    patient: bool,
    /// What it has made of the object and wants to publish.
    edited: Option<Value>,
    published: u64,
    interrupted: u64,
}

impl User {
    /// A user who comes for the first time soon after `now`.
    pub fn new(now: u64, rng: &mut Rng) -> Self {
        let mut user = Self {
            comes_us: 0,
            goes_us: 0,
            edit_us: 0,
            editing_us: None,
            patient: false,
            edited: None,
            published: 0,
            interrupted: 0,
        };
        user.plan(now, rng);
        user
    }

    /// The next visit.
    pub fn plan(&mut self, now: u64, rng: &mut Rng) {
        self.comes_us = now + rng.below(300_000);
        self.goes_us = if self.patient { u64::MAX } else { self.comes_us + 100_000 + rng.below(1_500_000) };
        self.edit_us = 10_000 + rng.below(LONGEST_EDIT_US - 10_000);
        if !self.patient && rng.chance(0.125) {
            self.edit_us *= STUBBORN;
        }
        self.editing_us = None;
    }

    /// From now on this user comes, stays until it has edited once, and then stays away.
    pub fn insist(&mut self, now: u64) {
        self.patient = true;
        self.comes_us = self.comes_us.min(now);
        self.goes_us = u64::MAX;
        self.edit_us = self.edit_us.min(LONGEST_EDIT_US);
    }

    /// Whether it stays until it has edited.
    pub fn is_patient(&self) -> bool {
        self.patient
    }

    /// What the user wants, by how far the hand is from the object.
    pub fn wish(&self, now: u64) -> Wish {
        let moved = |since_us: u64| SPEED_M_PER_S * now.saturating_sub(since_us) as f64 * 1e-6;
        let nearest = (AWAY_M - moved(self.comes_us)).max(0.0);
        APPROACH.wish((nearest + moved(self.goes_us)).min(AWAY_M) as f32)
    }

    /// It has turned away, and is as far as it goes.
    pub fn is_gone(&self, now: u64) -> bool {
        now > self.goes_us && now - self.goes_us > 100_000
    }

    /// The user may edit `base`; what it has made of it, once it has finished.
    ///
    /// # Errors
    /// Nobody has ever made `base`.
    pub fn edits(&mut self, now: u64, base: &Value, history: &mut History) -> Result<Option<Value>, String> {
        let since_us = now.saturating_sub(*self.editing_us.get_or_insert(now));
        if since_us < self.edit_us && self.wish(now) != Wish::Leave {
            return Ok(None);
        }
        self.edited = Some(history.edit(base)?);
        Ok(self.edited)
    }

    /// Whether it waits to be told that what it made is published.
    pub fn waits(&self) -> bool {
        self.edited.is_some()
    }

    /// What it made is published, as this version.
    ///
    /// # Errors
    /// It has made nothing, or what the checker says.
    pub fn has_published(
        &mut self,
        version: u32,
        now: u64,
        history: &mut History,
        rng: &mut Rng,
    ) -> Result<(), String> {
        let value = self.edited.take().ok_or_else(|| format!("version {version} was never edited"))?;
        history.publish(&value)?;
        self.published += 1;
        self.plan(now, rng);
        if self.patient {
            self.comes_us = u64::MAX;
        }
        Ok(())
    }

    /// It may no longer, and had not finished.
    pub fn is_interrupted(&mut self) {
        self.interrupted += 1;
        self.editing_us = None;
    }

    /// Nobody will ever tell it what became of what it made.
    pub fn forgets(&mut self) {
        self.edited = None;
    }

    /// Publications so far, and rights to edit that ended before.
    pub fn counts(&self) -> (u64, u64) {
        (self.published, self.interrupted)
    }
}
