//! A user at an object: comes near, edits as soon as it may, moves away; sometimes loses patience before.

use haptic_protocol::roles::collaborative::{Approach, Wish};

use super::world::Dice;

/// How fast a hand comes and goes, m/s.
const SPEED_M_PER_S: f64 = 0.5;
/// Where it rests, away from the object, m.
const AWAY_M: f64 = 0.05;
/// Where it asks, and where it gives back.
const APPROACH: Approach = Approach { near_m: 0.02, far_m: 0.03 };
/// Longest edit, µs; of an impatient hand, one in 8 takes six times as long.
pub const LONGEST_EDIT_US: u64 = 120_000;
/// Longer than a lease or a turn.
const STUBBORN: u64 = 6;

/// One user's visits.
#[derive(Clone, Debug)]
pub struct Hand {
    /// Turns toward the object at this time, µs.
    comes_us: u64,
    /// Turns away, done or not.
    goes_us: u64,
    /// How long it edits once it may.
    edit_us: u64,
    /// Since when it has been editing.
    editing_us: Option<u64>,
}

impl Hand {
    /// A hand that comes for the first time soon after `now`.
    pub fn new(now: u64, dice: &mut Dice) -> Self {
        let mut hand = Self { comes_us: 0, goes_us: 0, edit_us: 0, editing_us: None };
        hand.plan(now, dice, false);
        hand
    }

    /// The next visit. A `patient` hand stays until it has edited.
    pub fn plan(&mut self, now: u64, dice: &mut Dice, patient: bool) {
        self.comes_us = now + dice.below(300_000);
        self.goes_us = if patient { u64::MAX } else { self.comes_us + 100_000 + dice.below(1_500_000) };
        self.edit_us = 10_000 + dice.below(LONGEST_EDIT_US - 10_000);
        if !patient && dice.chance(0.125) {
            self.edit_us *= STUBBORN;
        }
        self.editing_us = None;
    }

    /// From now on this hand comes, and stays until it has edited.
    pub fn insist(&mut self, now: u64) {
        self.comes_us = self.comes_us.min(now);
        self.goes_us = u64::MAX;
        self.edit_us = self.edit_us.min(LONGEST_EDIT_US);
    }

    /// What the user wants, by how far the hand is from the object.
    pub fn wish(&self, now: u64) -> Wish {
        let moved = |since_us: u64| SPEED_M_PER_S * now.saturating_sub(since_us) as f64 * 1e-6;
        let nearest = (AWAY_M - moved(self.comes_us)).max(0.0);
        APPROACH.wish((nearest + moved(self.goes_us)).min(AWAY_M) as f32)
    }

    /// It has done all it wanted to, for good.
    pub fn rest(&mut self) {
        self.comes_us = u64::MAX;
    }

    /// It has turned away, and is as far as it goes.
    pub fn is_gone(&self, now: u64) -> bool {
        now > self.goes_us && now - self.goes_us > 100_000
    }

    /// The user may edit; whether it has finished.
    pub fn edits(&mut self, now: u64) -> bool {
        now.saturating_sub(*self.editing_us.get_or_insert(now)) >= self.edit_us
    }

    /// It may not, or no longer.
    pub fn stops(&mut self) {
        self.editing_us = None;
    }
}
