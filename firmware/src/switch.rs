//! The hold-to-run switch: a contact in a person's hand, which motors run only while it is held (`board.hold_switch`).
//!
//! It is looked at after every tick. One look that finds it open turns the motors off at the next tick, 2 ms after it opened at the most: its wire is
//! pulled down, so a cut one is an open one. Held is what [`STEADY`] looks in a row found closed, so that a contact that bounces holds nothing; and it
//! must have been seen open since the start, so that one that is tied down holds nothing either. After a release it takes `arm` to go on.
//!
//! **Limit**: a switch that is tied down later cannot be distinguished from one that is held.

use core::sync::atomic::{AtomicU32, Ordering};

use cohold_core::safety::Mode;

use crate::signals::Signals;

/// Looks, and so ms, that it has to be closed for.
pub const STEADY: u32 = 50;

/// What came of looking at it; one priority looks.
#[derive(Debug)]
pub struct Switch {
    /// 0 until it was seen open; then one more than the looks in a row that found it closed, up to [`STEADY`].
    closed: AtomicU32,
}

impl Switch {
    /// A switch that nobody has looked at.
    pub const fn unseen() -> Self {
        Self { closed: AtomicU32::new(0) }
    }

    /// Takes in a look; whether it is held.
    fn look(&self, closed: bool) -> bool {
        let now = match (closed, self.closed.load(Ordering::Relaxed)) {
            (false, _) => 1,
            (true, 0) => 0,
            (true, before) => before.saturating_add(1).min(STEADY + 1),
        };
        self.closed.store(now, Ordering::Relaxed);
        now > STEADY
    }

    /// Takes in a look, and turns the motors off if they are to be on while it is held only, and it is not.
    pub fn see(&self, signals: &Signals, closed: bool) {
        let held = self.look(closed);
        signals.held.set(held);
        let on = matches!(signals.mode.get(), Mode::Armed | Mode::Probing);
        if on && !held && signals.by_switch.get() {
            signals.released.set(true);
            signals.disarm.release(true);
        }
    }
}
