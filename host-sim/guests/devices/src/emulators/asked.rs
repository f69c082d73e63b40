//! What was asked of an emulated device: the newest orders, and how many there were.

use std::ops::Deref;

/// So many orders are kept at least: at 1 kHz, 17 minutes of them.
pub const KEPT: usize = 1 << 20;

/// The newest forces (N) or torques (N·m) that were asked for, each with its time, s.
#[derive(Clone, Debug, Default)]
pub struct Asked<const N: usize> {
    newest: Vec<(f64, [f64; N])>,
    count: u64,
    last_push_s: Option<f64>,
}

impl<const N: usize> Asked<N> {
    /// Takes an order of this time, s.
    pub fn push(&mut self, at_s: f64, order: [f64; N]) {
        if self.newest.len() >= 2 * KEPT {
            self.newest.drain(..KEPT);
        }
        self.newest.push((at_s, order));
        self.count += 1;
        if order != [0.0; N] {
            self.last_push_s = Some(at_s);
        }
    }

    /// How many there were.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// When one that was not zero was asked for last, s.
    pub fn last_push_s(&self) -> Option<f64> {
        self.last_push_s
    }
}

impl<const N: usize> Deref for Asked<N> {
    type Target = [(f64, [f64; N])];

    fn deref(&self) -> &Self::Target {
        &self.newest
    }
}
