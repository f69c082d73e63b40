//! How much of a line passes a seat.

use std::time::Instant;

pub use cohold_live::allowance::Allowance;

/// Bytes each second: 2,000 flows of 88 bytes, and what the carriers say.
pub const RATE: f64 = 200_000.0;
/// How many bytes at once.
pub const BURST: f64 = 50_000.0;
/// The least that a datagram counts, bytes.
pub const LEAST: usize = 88;

/// Whether a datagram of so many bytes passes a seat.
pub(crate) fn passes(allowance: &mut Allowance, now: Instant, bytes: usize) -> bool {
    allowance.takes(now, bytes.max(LEAST) as f64, [RATE, BURST])
}
