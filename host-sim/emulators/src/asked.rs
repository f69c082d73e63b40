//! What was asked of an emulated device: the newest orders, and how many there were.

use std::ops::Deref;

/// So many orders are kept at least: at 1 kHz, 17 minutes of them.
const KEPT: usize = 1 << 20;

/// The newest forces (N) or torques (N·m) that were asked for, each with its time, s.
#[derive(Clone, Debug, Default)]
pub struct Asked<const N: usize> {
    newest: Vec<(f64, [f64; N])>,
    count: u64,
    last_push_s: Option<f64>,
}

impl<const N: usize> Asked<N> {
    pub(crate) fn push(&mut self, at_s: f64, order: [f64; N]) {
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

#[cfg(test)]
mod tests {
    use super::{Asked, KEPT};

    /// An emulator that runs for days does not grow with them.
    #[test]
    fn the_newest_orders_are_kept_and_all_are_counted() {
        let mut asked = Asked::<1>::default();
        let count = 5 * KEPT as u64 + 3;
        (0..count).for_each(|at| asked.push(at as f64, [if at % 1000 == 7 { 1.0 } else { 0.0 }]));
        assert!((KEPT..=2 * KEPT).contains(&asked.len()), "{}", asked.len());
        let all = asked.windows(2).all(|two| two[1].0 == two[0].0 + 1.0);
        assert!(all && asked.last().map(|last| last.0) == Some(count as f64 - 1.0));
        let last_push_s = (0..count).rev().find(|at| at % 1000 == 7).map(|at| at as f64);
        assert_eq!((asked.count(), asked.last_push_s()), (count, last_push_s));
    }
}
