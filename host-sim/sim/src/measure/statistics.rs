//! Means over the last half of a run, when what the start left behind has died away.

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

    /// The means; 0 of nothing.
    pub fn means(&self) -> [f64; N] {
        self.sums.map(|sum| sum / self.count.max(1) as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_last_half_counts() {
        let mut halves = LastHalf::new(4);
        assert_eq!(halves.means(), [0.0, 0.0]);
        (0..4).for_each(|tick| halves.see(tick, [tick as f64, (tick * tick) as f64]));
        let [mean, mean_square] = halves.means();
        assert_eq!(Statistics::of_moments(mean, mean_square), Statistics { mean: 2.5, sd: 0.5 });
    }
}
