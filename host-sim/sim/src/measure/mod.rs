//! What is measured of a run: means over its last half, when what the start left behind has died away, and what a hand feels of a
//! scene, its mass and its drag.

pub mod apparent_mass;
pub mod growth;
pub mod port;
pub mod swing;

use serde::Serialize;

/// Mean and standard deviation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Statistics {
    /// Mean.
    pub mean: f64,
    /// Standard deviation, of the whole and not of a sample.
    pub sd: f64,
}

impl Statistics {
    /// From the mean and the mean of the squares.
    pub fn of_moments(mean: f64, mean_square: f64) -> Self {
        Self { mean, sd: (mean_square - mean * mean).max(0.0).sqrt() }
    }
}

/// Means of `N` quantities over the last half of a run.
#[derive(Clone, Copy, Debug)]
pub struct LastHalf<const N: usize> {
    from_tick: u64,
    count: u64,
    sums: [f64; N],
}

impl<const N: usize> LastHalf<N> {
    /// Of a run of so many ticks.
    pub fn new(ticks: u64) -> Self {
        Self { from_tick: ticks / 2, count: 0, sums: [0.0; N] }
    }

    /// Takes in the values of this tick, if it is in the last half.
    pub fn see(&mut self, tick: u64, values: [f64; N]) {
        if tick >= self.from_tick {
            self.count += 1;
            self.sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        }
    }

    /// The means; no number of nothing.
    pub fn means(&self) -> [f64; N] {
        self.sums.map(|sum| sum / self.count as f64)
    }
}
