//! Hold to run: motors are on only while an operator is there, unless he said `arm alone`.
//!
//! The port notes the tick at which the operator was last heard: a datagram under his key, in this session, not old. The supervisor,
//! without which the watchdog bites, looks every few ms whether that is longer ago than `safety.operator_lost_s`.

use haptic_core::safety::Mode;

use crate::signals::Signals;

/// Turns the motors off if the operator has been silent for too long; true when it did.
pub fn let_go(signals: &Signals) -> bool {
    let on = matches!(signals.mode.get(), Mode::Armed | Mode::Probing);
    let silent = signals.ticks.get().wrapping_sub(signals.heard.get());
    let patience = signals.patience.get();
    let over = on && patience != 0 && silent > patience && silent < u32::MAX / 2;
    if over {
        signals.let_go.set(true);
        signals.disarm.release(true);
    }
    over
}
