//! How much may pass: so many bytes each second, and so many at once.

use std::time::Instant;

/// Bytes each second: 2,000 flows of 88 bytes, and what the carriers say.
pub const RATE: f64 = 200_000.0;
/// How many bytes at once.
pub const BURST: f64 = 50_000.0;
/// The least that a datagram counts, bytes.
pub const LEAST: usize = 88;

/// Of one sender, what may pass yet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Allowance {
    left: f64,
    counted: Instant,
}

impl Allowance {
    /// A whole one.
    pub(crate) fn new(now: Instant) -> Self {
        Self { left: BURST, counted: now }
    }

    /// Whether a datagram of so many bytes passes; if so, it is taken off.
    pub(crate) fn takes(&mut self, now: Instant, bytes: usize) -> bool {
        let since_s = now.saturating_duration_since(self.counted).as_secs_f64();
        self.left = (self.left + RATE * since_s).min(BURST);
        self.counted = now;
        let cost = bytes.max(LEAST) as f64;
        let passes = self.left >= cost;
        self.left -= if passes { cost } else { 0.0 };
        passes
    }
}
