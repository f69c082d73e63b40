//! Times and their quantiles, each within 1.6 %, in ns; a time beyond 2⁴⁰ ns (18 min) counts as that.

use hdrhistogram::Histogram;
use serde::Serialize;

/// Significant figures that are kept: bins no wider than 1 % of the time that they hold.
const FIGURES: u8 = 2;
const LONGEST_NS: u64 = 1 << 40;

/// How often each time was seen.
#[derive(Clone, Debug)]
pub struct Times {
    bins: Histogram<u64>,
    largest_ns: u64,
}

/// What times say, in µs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Quantiles {
    /// Number of times that were added.
    pub samples: u64,
    /// Median of the times, µs.
    pub p50_us: f64,
    /// Time that 90 % of the samples do not exceed, µs.
    pub p90_us: f64,
    /// Time that 99 % of the samples do not exceed, µs.
    pub p99_us: f64,
    /// Time that 99.9 % of the samples do not exceed, µs.
    pub p999_us: f64,
    /// Longest time of all, exact, µs.
    pub largest_us: f64,
}

/// A record in which there is no time yet.
impl Default for Times {
    fn default() -> Self {
        let bins = Histogram::new_with_bounds(1, LONGEST_NS, FIGURES).expect("bounds that are allowed");
        Self { bins, largest_ns: 0 }
    }
}

impl Times {
    /// Adds one time, ns; one beyond 2⁴⁰ ns goes into the last bin.
    pub fn add(&mut self, ns: u64) {
        self.bins.saturating_record(ns);
        self.largest_ns = self.largest_ns.max(ns);
    }

    /// How many were added.
    pub fn samples(&self) -> u64 {
        self.bins.len()
    }

    /// As if none had been added.
    pub fn clear(&mut self) {
        self.bins.reset();
        self.largest_ns = 0;
    }

    /// How many took up to so long, µs, and longer than the one before: bins that double from 1 µs on, up to the longest time.
    pub fn histogram(&self) -> Vec<(f64, u64)> {
        let bins = self.bins.iter_log(1_000, 2.0);
        let bins = bins.map(|bin| (1e-3 * (bin.value_iterated_to() + 1) as f64, bin.count_since_last_iteration()));
        bins.skip_while(|(_, count)| *count == 0).collect()
    }

    /// The usual quantiles; 0 without samples.
    pub fn quantiles(&self) -> Quantiles {
        let us = |fraction| 1e-3 * self.bins.value_at_quantile(fraction).min(self.largest_ns) as f64;
        Quantiles {
            samples: self.bins.len(),
            p50_us: us(0.5),
            p90_us: us(0.9),
            p99_us: us(0.99),
            p999_us: us(0.999),
            largest_us: 1e-3 * self.largest_ns as f64,
        }
    }
}

#[cfg(test)]
#[path = "../tests/inside/quantiles.rs"]
mod tests;
