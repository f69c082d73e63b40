//! Times and their quantiles, each within 1.6 %, in ns; a time beyond 2⁴⁰ ns (18 min) counts as that.

use hdrhistogram::Histogram;
use serde::Serialize;

/// Significant figures that are kept: bins no wider than 1 % of the time that they hold.
const FIGURES: u8 = 2;
const LONGEST_NS: u64 = 1 << 40;

/// How often each time was seen.
#[derive(Clone, Debug)]
pub(crate) struct Times {
    bins: Histogram<u64>,
    largest_ns: u64,
}

/// What times say, in µs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Quantiles {
    pub(crate) samples: u64,
    pub(crate) p50_us: f64,
    pub(crate) p90_us: f64,
    pub(crate) p99_us: f64,
    pub(crate) p999_us: f64,
    pub(crate) largest_us: f64,
}

impl Times {
    pub(crate) fn new() -> Self {
        Self {
            bins: Histogram::new_with_bounds(1, LONGEST_NS, FIGURES).expect("bounds that are allowed"),
            largest_ns: 0,
        }
    }

    pub(crate) fn add(&mut self, ns: u64) {
        self.bins.saturating_record(ns);
        self.largest_ns = self.largest_ns.max(ns);
    }

    /// The usual quantiles; 0 without samples.
    pub(crate) fn quantiles(&self) -> Quantiles {
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
#[path = "../../tests/inside/live_quantiles.rs"]
mod tests;
