//! Hold to run: motors are on only while an operator lets them, unless they run alone.
//!
//! What decides is [`haptic_protocol::lease`]. Here it meets the board: the port brings the operator's words, the console starts runs,
//! and the supervisor, without which the watchdog bites, looks every few ms. A look compares what the lease wants with what the tick
//! does. If the lease wants motors off, the next tick turns them off. If the tick has turned them off for a reason of its own, such as
//! a fault, a released switch or the end of a probe, then the lease ends, too. So motors are off within `safety.operator_lost_s` after
//! the operator's last permission, whatever becomes of the datagrams that take it back.

use haptic_core::safety::Mode;
use haptic_protocol::lease::{AtBoard, Holder, Motors, No, Told, Word};

use crate::signals::Signals;

/// Between two looks of the supervisor, ms.
pub const LOOK_EVERY: u32 = 5;
/// From a look that finds the lease over to motors that are off, µs: the time between two looks, and a tick.
const TO_TURN_OFF_US: u64 = 1_000 * (LOOK_EVERY as u64 + 1);

/// The board's lease, and what is under way of it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Hold {
    holder: Holder,
    /// The tick has an order that turns motors on.
    starting: bool,
    /// Why the motors went off by the lease, if they did.
    off: Option<&'static str>,
}

impl Hold {
    /// Takes in an event that is not a start: nothing else is refused.
    pub fn step(&mut self, now_us: u64, event: AtBoard) {
        let _ = self.holder.step(now_us, event);
    }

    /// The operator's newest datagram says this ([`haptic_protocol::link::Link::heard`]); true if motors go off by it.
    pub fn hear(&mut self, now_us: u64, (word, echo_us): (u8, Option<u64>), signals: &Signals) -> bool {
        self.step(now_us, AtBoard::Heard { word: Word::of_byte(word), echo_us });
        let off = self.turns_off(signals);
        self.off = if off { Some("motors off: the operator does not let them run; ") } else { self.off };
        off
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
        (self.starting, self.off) = (true, None);
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
        if before != self.holder.motors() {
            self.off = Some("motors off: the operator was silent; ");
        }
        self.turns_off(signals)
    }

    /// What is said in every datagram to the operator.
    pub fn told(&self, signals: &Signals) -> Told {
        self.holder.told(self.drives(signals))
    }

    /// Why the motors went off, or for whom they are on, if `status` is to say it.
    pub fn says(&self) -> Option<&'static str> {
        let alone = (self.holder.motors() == Motors::Alone).then_some("armed alone; ");
        self.off.or(alone)
    }

    fn drives(&self, signals: &Signals) -> bool {
        self.starting || matches!(signals.mode.get(), Mode::Armed | Mode::Probing)
    }

    fn turns_off(&self, signals: &Signals) -> bool {
        let over = self.holder.motors() == Motors::Off && self.drives(signals);
        if over {
            signals.disarm.release(true);
        }
        over
    }
}
