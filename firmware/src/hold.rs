//! Hold to run: motors are on only while an operator lets them, unless they run alone.
//!
//! What decides is [`cohold_protocol::lease`]. Here it meets the board: the port brings the operator's words, the console starts runs,
//! and the supervisor, without which the watchdog bites, looks every few ms. A look compares what the lease wants with what the tick
//! does. If the lease wants motors off, the next tick turns them off. If the tick has turned them off for a reason of its own, such as
//! a fault, a released switch or the end of a probe, then the lease ends, too. So motors are off within `safety.operator_lost_s` after
//! the operator's last permission, whatever becomes of the datagrams that take it back.

use cohold_core::safety::Mode;
use cohold_protocol::lease::{AtBoard, Holder, Motors, No, Told, Word};

use crate::signals::Signals;

/// Between two looks of the supervisor, ms.
pub const LOOK_EVERY: u32 = 5;
/// From a look that finds the lease over to motors that are off, µs: the time between two looks, and a tick.
const TO_TURN_OFF_US: u64 = 1_000 * (LOOK_EVERY as u64 + 1);
/// What `status` says of motors that a word turned off, or another operator.
const NOT_LET: &str = "motors off: the operator does not let them run; ";
/// The same of motors whose lease has run out.
const SILENT: &str = "motors off: the operator was silent; ";

/// The board's lease, and what is under way of it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Hold {
    holder: Holder,
    /// The tick has an order that turns motors on.
    starting: bool,
    /// Why the motors went off by the lease; empty if they did not.
    off: &'static str,
}

impl Hold {
    /// Takes in an event that is not a start: nothing else is refused.
    pub fn step(&mut self, now_us: u64, event: AtBoard) {
        let _ = self.holder.step(now_us, event);
    }

    /// The operator's newest datagram says this ([`cohold_protocol::link::Link::heard`]); true if motors go off by it.
    pub fn hear(&mut self, now_us: u64, (word, echo_us): (u8, Option<u64>), signals: &Signals) -> bool {
        self.step(now_us, AtBoard::Heard { word: Word::of_byte(word), echo_us });
        self.turns_off(signals, NOT_LET)
    }

    /// Turns motors on by giving the tick an order, if the lease lets them: `lost_s` is `safety.operator_lost_s`.
    ///
    /// # Errors
    /// Why the lease does not.
    pub fn start(
        &mut self,
        now_us: u64,
        (word, alone): (Word, bool),
        lost_s: f64,
        signals: &Signals,
        order: impl FnOnce(),
    ) -> Result<(), No> {
        self.look(now_us, signals);
        if self.holder.motors() == Motors::Off {
            // A cast saturates.
            self.holder.lease_us = ((1e6 * lost_s) as u64).saturating_sub(TO_TURN_OFF_US);
        }
        self.holder.step(now_us, AtBoard::Start { word, alone })?;
        (self.starting, self.off) = (true, "");
        order();
        Ok(())
    }

    /// The tick has carried the order out, or will not.
    pub fn started(&mut self) {
        self.starting = false;
    }

    /// Motors off, whoever turned them on.
    pub fn off(&mut self, now_us: u64, signals: &Signals) {
        self.step(now_us, AtBoard::Off);
        signals.disarm.release(true);
    }

    /// Compares lease and tick; true if motors go off because the lease is over.
    pub fn look(&mut self, now_us: u64, signals: &Signals) -> bool {
        if !self.drives(signals) {
            self.step(now_us, AtBoard::Off);
        }
        let before = self.holder.motors();
        self.step(now_us, AtBoard::Look);
        let lapsed = (before != self.holder.motors()).then_some(SILENT);
        self.turns_off(signals, lapsed.unwrap_or(NOT_LET))
    }

    /// What is said in every datagram to the operator.
    pub fn told(&self, signals: &Signals) -> Told {
        self.holder.told(self.drives(signals))
    }

    /// Why the motors went off, or for whom they are on, as `status` says it; empty if it does not.
    pub fn says(&self) -> &'static str {
        let alone = (self.holder.motors() == Motors::Alone).then_some("armed alone; ");
        alone.unwrap_or(self.off)
    }

    fn drives(&self, signals: &Signals) -> bool {
        self.starting || matches!(signals.mode.get(), Mode::Armed | Mode::Probing)
    }

    fn turns_off(&mut self, signals: &Signals, why: &'static str) -> bool {
        let over = self.holder.motors() == Motors::Off && self.drives(signals);
        if over {
            signals.disarm.release(true);
            self.off = if self.off.is_empty() { why } else { self.off };
        }
        over
    }
}
