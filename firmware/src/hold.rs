//! Hold to run: motors are on only while an operator lets them, unless he said `arm alone`.
//!
//! Running is a lease and not an order. Everything that the operator's end says has in it whether the motors may run, and the newest time of
//! this board's clock that it knew when it said so ([`haptic_protocol::link::Link::consent`]). The port notes the newest yes, and lets go
//! when something newer says no; the supervisor, without which the watchdog bites, looks every few ms whether that yes is
//! longer ago than `safety.operator_lost_s`. So motors go off within that time after the operator's last yes, whatever becomes
//! of the datagrams that say no: who drops, holds back or reorders them gains nothing.

use haptic_core::safety::Mode;

use crate::signals::Signals;

/// Between two looks of the supervisor, ticks.
pub const LOOK_EVERY: u32 = 5;
/// From a look that finds the lease over to the motors being off, beside the look itself, ticks.
const TO_TURN_OFF: u32 = 1;

/// Notes what the operator's newest word in the session at hand is: when he let the motors run at the earliest, µs of this board's
/// clock, if he does.
pub fn note(signals: &Signals, now_us: u64, consented_us: Option<u64>) {
    if let Some(consented_us) = consented_us {
        // A count of ticks wraps: what is longer ago than three weeks is three weeks ago.
        let ticks = now_us.saturating_sub(consented_us).div_ceil(1_000).min((u32::MAX / 4).into());
        signals.consented.set(signals.ticks.get().wrapping_sub(ticks as u32));
    }
    signals.consent.set(consented_us.is_some());
}

/// What [`let_go`] waits for of a lease of so many ticks, so that the motors are off when it ends.
pub fn patience(lease: u32) -> u32 {
    lease.saturating_sub(LOOK_EVERY + TO_TURN_OFF).max(1)
}

/// Turns the motors off if the operator does not let them run any more; true when it did.
pub fn let_go(signals: &Signals) -> bool {
    let on = matches!(signals.mode.get(), Mode::Armed | Mode::Probing);
    let ago = signals.ticks.get().wrapping_sub(signals.consented.get());
    let patience = signals.patience.get();
    let silent = ago > patience && ago < u32::MAX / 2;
    let over = on && patience != 0 && (silent || !signals.consent.get());
    if over {
        signals.let_go.set(silent);
        signals.disarm.release(true);
    }
    over
}
