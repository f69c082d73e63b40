//! How much may pass, of datagrams or anything else: so much each second, and so much at once.

use std::time::Instant;

/// What may pass yet.
#[derive(Clone, Copy, Debug)]
pub struct Allowance {
    left: f64,
    /// When it was looked at last.
    pub counted: Instant,
}

impl Allowance {
    /// A whole one.
    pub fn new(most: f64, now: Instant) -> Self {
        Self { left: most, counted: now }
    }

    /// Whether so much passes, of `most` at once and so much each second; if so, it is taken off.
    pub fn takes(&mut self, now: Instant, cost: f64, [each_s, most]: [f64; 2]) -> bool {
        let since_s = now.saturating_duration_since(self.counted).as_secs_f64();
        self.left = (self.left + each_s * since_s).min(most);
        self.counted = now;
        let passes = self.left >= cost;
        self.left -= if passes { cost } else { 0.0 };
        passes
    }
}
