//! Event-triggered sending: a law that sends only what is worth a packet, and is silent on purpose otherwise.
//!
//! Each packet period the law is asked ([`super::Law::speaks`]); where it says no, of every axis, nothing is sent. Whatever it says, a packet goes out
//! at the latest [`LONGEST`] after the one before, and in every period while the peer is not engaged.
//!
//! **What the receiver makes of it.** To it silence on purpose is silence: the newest packet is held and ages, the degradation counts the
//! periods. So nobody waits longer for a dead peer than without: `safety.fade_s`, `safety.disengage_s` and `safety.peer_lost_s` count
//! from the last packet heard, which came at most [`LONGEST`] before the peer died, and never after. That one lost packet must not fade
//! anything, `longest_periods` sees to: the longest silence is at most half of `safety.fade_s`. On the way back to full coordination a packet
//! counts for as many periods as its sender may have kept silent.
//!
//! A link measures delay from when its own newest datagram was opened at the other end: the wait for a packet is in it, at most the
//! longest silence, and so at most half of `safety.max_delay_s`.

use crate::settings::{Allowed, Key, Refused, Settings};

/// Longest silence on purpose, s; 0: a packet in each packet period. A key of every law that sends by events.
pub const LONGEST: Key = Key::number("event.longest_s", 0.0, [0.0, 10.0], "s")
    .means("Longest that a law keeps silent that sends only what is worth a packet; 0: a packet each packet period.");

/// The longest silence on purpose, s ([`LONGEST`]), checked against the times of `safety`.
///
/// # Errors
/// A longest silence of more than half of `safety.fade_s` or `safety.max_delay_s`.
pub fn longest_s(settings: &Settings) -> Result<f64, Refused<'static>> {
    let longest_s = settings.own(&LONGEST);
    let (safety, value) = (&settings.safety, settings.own_value(&LONGEST));
    let refused = |allowed| Err(Refused { key: LONGEST.name, value, allowed: Allowed::Only(allowed), unit: "" });
    if 2.0 * longest_s > safety.fade_s && longest_s > 0.0 {
        return refused("at most half of safety.fade_s: one lost packet must not fade the coordination");
    }
    if 2.0 * longest_s > safety.max_delay_s {
        return refused("at most half of safety.max_delay_s: the wait for a packet is measured as delay");
    }
    Ok(longest_s)
}

/// From one packet to the next at most, in packet periods; 1: nobody keeps silent.
pub(crate) fn longest_periods(settings: &Settings) -> Result<u32, Refused<'static>> {
    Ok(settings.timing.packet_periods(longest_s(settings)?).max(1))
}
