//! What is measured of a run: means over its last half, when what the start left behind has died away, and what a hand feels of a
//! scene: its mass, its drag, its impedance.

pub mod apparent_mass;
pub mod at_hand;
pub mod growth;
pub mod hands;
pub mod impedance;
pub mod led;
pub mod port;
pub mod swing;

use cohold_core::num::Scalar;
use serde::Serialize;

/// A number type in which runs are measured: `f64`, or one `f64` in each lane ([`crate::lanes`]).
pub trait Figure: Scalar<Counter = Self> {
    /// The number one half.
    const HALF: Self;
    /// The larger of two numbers; where one is NaN, the other.
    #[must_use]
    fn larger(self, other: Self) -> Self;
    /// The number itself if it is finite, else infinity.
    #[must_use]
    fn or_infinite(self) -> Self;
    /// Square root; NaN of a negative number.
    #[must_use]
    fn root(self) -> Self;
}

impl Figure for f64 {
    const HALF: Self = 0.5;
    #[inline]
    fn larger(self, other: Self) -> Self {
        Self::max(self, other)
    }
    #[inline]
    fn or_infinite(self) -> Self {
        if Self::is_finite(self) { self } else { Self::INFINITY }
    }
    #[inline]
    fn root(self) -> Self {
        Self::sqrt(self)
    }
}

/// Mean and standard deviation of a quantity, in its unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Statistics {
    /// Mean of the values.
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
pub struct LastHalf<const N: usize, F = f64> {
    from_tick: u64,
    count: u64,
    sums: [F; N],
}

impl<const N: usize, F: Figure> LastHalf<N, F> {
    /// A measurement over a run of `ticks` ticks.
    pub fn new(ticks: u64) -> Self {
        Self { from_tick: ticks / 2, count: 0, sums: [F::ZERO; N] }
    }

    /// Takes in the values of this tick, if it is in the last half.
    #[inline]
    pub fn see(&mut self, tick: u64, values: [F; N]) {
        if tick >= self.from_tick {
            self.count += 1;
            self.sums.iter_mut().zip(values).for_each(|(sum, value)| *sum = *sum + value);
        }
    }

    /// With what `of` makes of each number.
    pub(crate) fn map<G>(&self, of: impl Fn(F) -> G) -> LastHalf<N, G> {
        LastHalf { from_tick: self.from_tick, count: self.count, sums: self.sums.map(of) }
    }
}

impl<const N: usize> LastHalf<N> {
    /// The means of the `N` quantities; NaN before any value was taken in.
    pub fn means(&self) -> [f64; N] {
        self.sums.map(|sum| sum / self.count as f64)
    }
}
