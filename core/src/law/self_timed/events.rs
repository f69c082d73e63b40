//! Which packets of a self-timed line are worth sending, where silence is allowed ([`event`]).
//!
//! The line takes any schedule of packets: each brings all that was sent before it, and the receiver emits the mean of what is
//! outstanding, so no schedule makes energy or drift. What silence costs is spare samples, one a tick, and an end without samples
//! stands. So N = [`TOGETHER`] samples go in one packet; of the [`super::incoming`] margin of 8 spare samples silence uses up N − 1,
//! and each beyond them makes the line a tick longer. A packet is worth sending when
//!
//! - N ticks have passed since the last one, and the line is in motion: either wave is more than a tenth of θ. Ticks that stand count, too,
//!   with nothing new to tell: both ends may stand because a packet was lost, each with fewer than N samples
//!   unsent; or
//! - the wave has changed by more than θ = [`THRESHOLD`] since the mean of those that the last packet brought: a jolt is not smoothed
//!   over N ticks.
//!
//! At rest nothing is worth a packet until [`event::LONGEST`] is over; the ends stand where they are.

use crate::law::event;
use crate::num::Scalar;
use crate::settings::{Key, Settings};

pub(super) const THRESHOLD: Key = Key::number("event.threshold_root_w", 0.2, [0.001, 100.0], "√W")
    .means("Self-timed line, where it may keep silent: change θ of the outgoing wave that is worth a packet; below θ/10 the line is at rest.");
pub(super) const TOGETHER: Key = Key::whole("event.together_ticks", 9, [1, 1000], "ticks")
    .means("Self-timed line, where it may keep silent: samples that go in one packet while the line is in motion.");

/// Share of θ below which the line is at rest.
const REST: f64 = 0.1;

/// Decides when a packet of the line is worth sending.
#[derive(Clone, Copy, Debug)]
pub(super) struct Events<C> {
    threshold: C,
    rest: C,
    together: u32,
    /// 1/T_c, 1/s.
    rate: C,
}

configured!([C: Scalar] Events<C> { threshold, rest, together, rate });

/// What the other end knows, if everything arrives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct LastSent<C> {
    /// The counters of the newest packet.
    integral: C,
    live: u32,
    /// The mean of the samples that it added, √W.
    mean: C,
    /// The newest sample of all, √W.
    pub(super) newest: C,
    /// Ticks since then that the line stood.
    pub(super) held: u32,
}

impl<C: Scalar> Events<C> {
    /// Only where silence is allowed.
    pub(super) fn build(settings: &Settings) -> Option<Self> {
        let threshold = settings.own(&THRESHOLD);
        (settings.own(&event::LONGEST) > 0.0).then(|| Self {
            threshold: C::from_f64(threshold),
            rest: C::from_f64(REST * threshold),
            together: (settings.own(&TOGETHER) as u32).max(settings.timing.ticks_per_packet),
            rate: C::from_f64(1.0 / settings.timing.control_period_s),
        })
    }

    /// Samples that go in one packet, beyond so many.
    pub(super) fn excess_ticks(&self, spare: u32) -> u32 {
        self.together.saturating_sub(spare)
    }

    /// Of so many spare samples, what the wait for a packet leaves.
    pub(super) fn remaining_ticks(&self, spare: u32) -> u32 {
        spare.saturating_sub(self.together - 1)
    }

    /// Whether a packet that says so many live ticks is worth sending; `taken` is the wave that came in last, √W.
    pub(super) fn exceeds_threshold(&self, last_sent: &LastSent<C>, taken: C, live: u32) -> bool {
        let unsent = live.wrapping_sub(last_sent.live);
        let moves = last_sent.newest.abs() > self.rest || taken.abs() > self.rest;
        let is_due = moves && unsent.saturating_add(last_sent.held) >= self.together;
        is_due || unsent > 0 && (last_sent.newest - last_sent.mean).abs() > self.threshold
    }

    /// A packet with these counters goes out.
    pub(super) fn note_sent(&self, last_sent: &mut LastSent<C>, integral: C, live: u32) {
        let samples = live.wrapping_sub(last_sent.live).cast_signed();
        if samples > 0 {
            last_sent.mean = ((integral - last_sent.integral) * self.rate).over(C::from_i32(samples));
        }
        (last_sent.integral, last_sent.live, last_sent.held) = (integral, live, 0);
    }
}
