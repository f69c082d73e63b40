//! What two links say to each other for themselves: acknowledgements of events, probes of the clock and their replies, and a goodbye.

use crate::bytes::layout;

layout! {
    /// Which events have arrived.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub message Ack("acknowledgement", 12 bytes, kind 4) {
        /// Every event before this number has arrived.
        4 => next: u32,
        /// Bit i: event `next + 1 + i` has arrived too.
        8 => ahead: u32,
    }
}

layout! {
    /// What time is it at your end? Also what keeps an idle session alive.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub message Probe("probe", 12 bytes, kind 5) {
        /// The prober's clock when it sent this, µs (t1).
        4 => sent_us: u64,
    }
}

layout! {
    /// The answer to a [`super::Probe`].
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub message Reply("reply", 28 bytes, kind 6) {
        /// The prober's clock when it sent the probe, µs (t1).
        4 => probe_sent_us: u64,
        /// The answerer's clock when the probe came, µs (t2).
        12 => probe_received_us: u64,
        /// The answerer's clock when it sent this, µs (t3).
        20 => sent_us: u64,
    }
}

layout! {
    /// The sender ends the session, and says so before it falls silent.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub message Goodbye("goodbye", 4 bytes, kind 7) {}
}
