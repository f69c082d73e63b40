//! A user at an object: comes near, edits as soon as it may, moves away; sometimes loses patience before.

use std::{cell::RefCell, rc::Rc};

use cohold_sim::rng::Rng;

use super::history::History;
use crate::roles::collaborative::{Approach, Value, Wish};

/// How fast a hand comes and goes, m/s.
const SPEED_M_PER_S: f64 = 0.5;
/// Where it rests, away from the object, m.
const AWAY_M: f64 = 0.05;
/// Where it asks, and where it gives back.
const APPROACH: Approach = Approach { near_m: 0.02, far_m: 0.03 };
/// Longest edit, µs; of an impatient user, one in 8 takes six times as long: longer than a lease or a turn.
pub(super) const LONGEST_EDIT_US: u64 = 120_000;
const STUBBORN: u64 = 6;

/// One user: this visit, and what the earlier ones came to.
pub(super) struct User {
    /// Turns toward the object at this time, µs.
    comes_us: u64,
    /// Turns away, done or not.
    goes_us: u64,
    /// How long it edits once it may.
    edit_us: u64,
    /// Since when it has been editing.
    editing_us: Option<u64>,
    /// Stays until it has edited.
    pub(super) patient: bool,
    /// Its edit of the object, until it hears that the edit is published.
    pub(super) edited: Option<Value>,
    pub(super) published: u64,
    /// Rights to edit that ended before it had finished.
    pub(super) interrupted: u64,
    /// Everything random about this peer.
    pub(super) rng: Rng,
    history: Rc<RefCell<History>>,
}

impl User {
    /// A user who comes for the first time soon after the beginning.
    pub(super) fn new(rng: Rng, history: &Rc<RefCell<History>>) -> Self {
        let mut user = Self {
            comes_us: 0,
            goes_us: 0,
            edit_us: 0,
            editing_us: None,
            patient: false,
            edited: None,
            published: 0,
            interrupted: 0,
            rng,
            history: Rc::clone(history),
        };
        user.plan(0);
        user
    }

    /// Draws when the user comes next, and how long it edits.
    pub(super) fn plan(&mut self, now: u64) {
        self.comes_us = now + self.rng.below(300_000);
        self.goes_us = if self.patient { u64::MAX } else { self.comes_us + 100_000 + self.rng.below(1_500_000) };
        self.edit_us = 10_000 + self.rng.below(LONGEST_EDIT_US - 10_000);
        if !self.patient && self.rng.chance(0.125) {
            self.edit_us *= STUBBORN;
        }
        self.editing_us = None;
    }

    /// From now on this user comes, stays until it has edited once, and then stays away.
    pub(super) fn insist(&mut self, now: u64) {
        self.patient = true;
        self.comes_us = self.comes_us.min(now);
        self.goes_us = u64::MAX;
        self.edit_us = self.edit_us.min(LONGEST_EDIT_US);
    }

    /// What the user wants, by how far the hand is from the object.
    pub(super) fn wish(&self, now: u64) -> Wish {
        let moved = |since_us: u64| SPEED_M_PER_S * now.saturating_sub(since_us) as f64 * 1e-6;
        let nearest = (AWAY_M - moved(self.comes_us)).max(0.0);
        APPROACH.wish((nearest + moved(self.goes_us)).min(AWAY_M) as f32)
    }

    /// It has turned away, and is as far as it goes.
    pub(super) fn is_gone(&self, now: u64) -> bool {
        now > self.goes_us && now - self.goes_us > 100_000
    }

    /// The user may edit `base`; what it has made of it, once it has finished.
    pub(super) fn edits(&mut self, now: u64, base: &Value) -> Option<Value> {
        let since_us = now.saturating_sub(*self.editing_us.get_or_insert(now));
        if since_us < self.edit_us && self.wish(now) != Wish::Leave {
            return None;
        }
        self.edited = Some(self.history.borrow_mut().edit(base));
        self.edited
    }

    /// What it made is published, as this version. Wrong if it has made nothing.
    pub(super) fn has_published(&mut self, version: u32, now: u64) {
        let mut history = self.history.borrow_mut();
        match self.edited.take() {
            Some(value) => history.publish(&value),
            None => history.complain(format!("version {version} was never edited")),
        }
        drop(history);
        self.published += 1;
        self.plan(now);
        if self.patient {
            self.comes_us = u64::MAX;
        }
    }

    /// What its role must not refuse it.
    pub(super) fn must<E: std::fmt::Display>(&self, done: Result<(), E>) {
        if let Err(error) = done {
            self.history.borrow_mut().complain(error.to_string());
        }
    }

    /// It may no longer, and had not finished.
    pub(super) fn is_interrupted(&mut self) {
        self.interrupted += 1;
        self.editing_us = None;
    }
}
