//! Times, sorted into bins that grow with the time: the quantiles of millions of samples in 16 kB, each within 1.6 %.
//!
//! 64 bins to every doubling. Unit: ns. A time beyond 2⁴⁰ ns (18 min) counts as that.

use serde::Serialize;

/// Bins to a doubling, as a power of 2.
const FINE: u32 = 6;
const DOUBLINGS: usize = 40;

/// How often each time was seen.
#[derive(Clone, Debug)]
pub struct Histogram {
    bins: Vec<u64>,
    count: u64,
    largest_ns: u64,
}

/// What a histogram says, in µs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Quantiles {
    /// Samples.
    pub samples: u64,
    /// Half of the samples are below.
    pub p50_us: f64,
    /// 90 % are below.
    pub p90_us: f64,
    /// 99 % are below.
    pub p99_us: f64,
    /// 99.9 % are below.
    pub p999_us: f64,
    /// The largest.
    pub largest_us: f64,
}

impl Default for Histogram {
    fn default() -> Self {
        Self { bins: vec![0; (DOUBLINGS + 1) << FINE], count: 0, largest_ns: 0 }
    }
}

impl Histogram {
    /// Counts one time.
    pub fn add(&mut self, ns: u64) {
        self.count += 1;
        self.largest_ns = self.largest_ns.max(ns);
        self.bins[Self::bin(ns)] += 1;
    }

    fn bin(ns: u64) -> usize {
        let ns = ns.min(1 << (DOUBLINGS as u32 - 1));
        // Below 64 every number has its own bin; above, the leading 1 and the 6 digits behind it.
        let shift = (u64::BITS - ns.leading_zeros()).saturating_sub(FINE + 1);
        ((shift as usize) << FINE) + (ns >> shift) as usize
    }

    /// The largest time of a bin.
    fn edge(bin: usize) -> u64 {
        let shift = (bin >> FINE).saturating_sub(1);
        let top = (bin - (shift << FINE)) as u64;
        ((top + 1) << shift) - 1
    }

    /// The time that this fraction of the samples does not exceed, ns; 0 without samples.
    pub fn quantile(&self, fraction: f64) -> u64 {
        let rank = ((fraction * self.count as f64).ceil() as u64).max(1);
        let mut seen = 0;
        let bin = self.bins.iter().position(|count| {
            seen += count;
            seen >= rank
        });
        bin.map_or(0, |bin| Self::edge(bin).min(self.largest_ns))
    }

    /// The usual quantiles.
    pub fn quantiles(&self) -> Quantiles {
        let us = |fraction| 1e-3 * self.quantile(fraction) as f64;
        Quantiles {
            samples: self.count,
            p50_us: us(0.5),
            p90_us: us(0.9),
            p99_us: us(0.99),
            p999_us: us(0.999),
            largest_us: 1e-3 * self.largest_ns as f64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_sorted_samples() {
        let mut samples: Vec<u64> = (0..20_000_u64).map(|at| at * at * at % 7_919_001 + at % 90).collect();
        let mut histogram = Histogram::default();
        samples.iter().for_each(|ns| histogram.add(*ns));
        samples.sort_unstable();
        for fraction in [0.001, 0.01, 0.1, 0.5, 0.9, 0.99, 0.999, 1.0] {
            let want = samples[((fraction * samples.len() as f64).ceil() as usize).max(1) - 1];
            let got = histogram.quantile(fraction);
            assert!(
                got >= want && got as f64 <= want as f64 * (1.0 + 1.0 / 64.0) + 1.0,
                "{fraction}: {got} for {want}"
            );
        }
        assert_eq!(histogram.quantiles().largest_us, 1e-3 * samples[samples.len() - 1] as f64);
    }

    #[test]
    fn every_time_has_a_bin_and_small_ones_their_own() {
        for ns in (0..70).chain([127, 128, 129, 1 << 30, (1 << 39) + 5, u64::MAX]) {
            let bin = Histogram::bin(ns);
            let least = bin.checked_sub(1).map_or(0, |bin| Histogram::edge(bin) + 1);
            assert!((least..=Histogram::edge(bin)).contains(&ns.min(1 << 39)), "{ns}");
            assert!(ns >= 64 || Histogram::edge(bin) == ns);
        }
        assert_eq!(Histogram::default().quantile(0.5), 0);
    }
}
