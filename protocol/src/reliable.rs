//! Reliable events: single events beside the flow that arrive once and in order (the "enhanced UDP" of Buttolo et al. 1997, §3.2.1).
//!
//! The sender keeps up to 8 events until they are acknowledged, each on its own timer that doubles with every repetition;
//! the receiver keeps up to 8 that came before their turn. The flow has no part in it and never waits. What does not fit
//! is refused at once ([`Full`]), so memory is bounded at both ends whatever the network does.
//!
//! **Invariant**: numbers are per pair of incarnations. A session may end and another begin; as long as both peers have
//! kept their memory, what was under way arrives once all the same. When either starts anew, both begin at 0 and what had
//! not been acknowledged is dropped and counted: it was meant for someone who is gone.

use crate::wire::{Ack, Event};

/// Events under way at once, in each direction.
pub const WINDOW: usize = 8;

/// The longest wait before an event is sent again, µs.
const LONGEST_WAIT_US: u64 = 1_000_000;

/// As many events are under way as memory allows: wait for some to arrive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{WINDOW} events are under way already: wait until some have arrived")]
pub struct Full;

#[derive(Clone, Copy, Debug)]
struct Pending {
    event: Event,
    /// Not before this time, µs.
    due_us: u64,
    sent: u32,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Sender {
    next: u32,
    pending: [Option<Pending>; WINDOW],
}

impl Sender {
    pub(crate) fn push(&mut self, event: Event) -> Result<u32, Full> {
        let number = self.next;
        // Never further ahead of the oldest than the other end can keep.
        let oldest = self.pending.iter().flatten().map(|pending| number.wrapping_sub(pending.event.number)).max();
        if oldest.is_some_and(|ahead| ahead as usize >= WINDOW) {
            return Err(Full);
        }
        let free = self.pending.iter_mut().find(|slot| slot.is_none()).ok_or(Full)?;
        *free = Some(Pending { event: event.numbered(number), due_us: 0, sent: 0 });
        self.next = number.wrapping_add(1);
        Ok(number)
    }

    /// The oldest event that is due, if any. It is due again after `timeout_us`, doubled for every time it was sent.
    pub(crate) fn due(&mut self, now: u64, timeout_us: u64) -> Option<Event> {
        let next = self.next;
        let due = self.pending.iter_mut().flatten().filter(|pending| pending.due_us <= now);
        let pending = due.max_by_key(|pending| next.wrapping_sub(pending.event.number))?;
        let wait = timeout_us.saturating_mul(1 << pending.sent.min(10)).min(LONGEST_WAIT_US);
        pending.due_us = now.saturating_add(wait);
        pending.sent = pending.sent.saturating_add(1);
        Some(pending.event)
    }

    /// Forgets what has arrived. An acknowledgement of what was never sent changes nothing.
    pub(crate) fn acknowledge(&mut self, ack: &Ack) {
        for slot in &mut self.pending {
            let Some(Pending { event, .. }) = slot else { continue };
            // How far beyond `next` the event is: negative ones are before it.
            let beyond = event.number.wrapping_sub(ack.next) as i32;
            let ahead = u32::try_from(beyond).ok().and_then(|beyond| beyond.checked_sub(1));
            let arrived = beyond < 0 || ahead.is_some_and(|bit| ack.ahead.checked_shr(bit).unwrap_or(0) & 1 == 1);
            let sensible = self.next.wrapping_sub(ack.next) as usize <= WINDOW;
            if arrived && sensible {
                *slot = None;
            }
        }
    }

    /// Everything is due now, as after a silence.
    pub(crate) fn hurry(&mut self) {
        for pending in self.pending.iter_mut().flatten() {
            pending.due_us = 0;
            pending.sent = 0;
        }
    }

    pub(crate) fn under_way(&self) -> usize {
        self.pending.iter().flatten().count()
    }
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Receiver {
    /// The number of the event that is handed out next.
    next: u32,
    early: [Option<Event>; WINDOW],
}

impl Receiver {
    fn slot(&mut self, number: u32) -> Option<&mut Option<Event>> {
        self.early.get_mut(number as usize % WINDOW)
    }

    /// Takes in an event; one that was handed out before, or is too far ahead, is dropped.
    pub(crate) fn receive(&mut self, event: Event) {
        if (event.number.wrapping_sub(self.next) as usize) < WINDOW
            && let Some(slot) = self.slot(event.number)
        {
            *slot = Some(event);
        }
    }

    pub(crate) fn take(&mut self) -> Option<Event> {
        let event = self.slot(self.next)?.take()?;
        self.next = self.next.wrapping_add(1);
        Some(event)
    }

    /// What has arrived, for the sender to forget.
    pub(crate) fn ack(&self) -> Ack {
        let has = |number: u32| self.early.get(number as usize % WINDOW).is_some_and(Option::is_some);
        let waiting = (0..WINDOW as u32).take_while(|ahead| has(self.next.wrapping_add(*ahead))).count() as u32;
        let next = self.next.wrapping_add(waiting);
        let mut ahead = 0;
        for bit in 0..(WINDOW as u32).saturating_sub(waiting + 1) {
            ahead |= u32::from(has(next.wrapping_add(1 + bit))) << bit;
        }
        Ack { next, ahead }
    }
}
