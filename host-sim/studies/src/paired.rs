//! Two sets of runs with the same seeds beside each other: how a figure of merit differs, run by run, with its 95 % interval.
//!
//! A **difference** is the second's figure less the first one's of the same seed: what the network does to both cancels, as far as their
//! packets meet the same losses. Its mean has Student's interval over the seeds; each interval is of one comparison, so of twenty that
//! mean nothing one lies beside 0. Where a run of either has no such figure there is no difference. There is no interval where every seed gave
//! the same runs, nor of a single seed.

use super::estimate::Estimate;
use super::sweep::{Row, all_same};

/// A figure of merit of two sets of runs, seed by seed: their means, and how the second differs from the first, where every run has it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Paired {
    /// Means over the seeds.
    pub means: [Option<f64>; 2],
    /// The second less the first; without an interval where every seed gave the same runs.
    pub difference: Option<Estimate>,
}

impl Paired {
    /// Over one pair of runs of the same seeds, or the mean over several.
    pub fn of(pairs: &[[&[Row]; 2]], metric: usize) -> Self {
        let seeds = pairs.iter().flatten().map(|runs| runs.len()).min().unwrap_or(0);
        let value = |which: usize, seed: usize| {
            pairs.iter().map(|pair| pair[which][seed].metrics[metric]).sum::<f64>() / pairs.len() as f64
        };
        let values = [0, 1].map(|which| {
            let values: Vec<f64> = (0..seeds).map(|seed| value(which, seed)).collect();
            Some(values).filter(|values| !values.is_empty() && !values.iter().any(|value| value.is_nan()))
        });
        let sure = pairs.iter().flatten().all(|runs| all_same(runs));
        let difference = values[0].as_ref().zip(values[1].as_ref()).map(|(first, this)| {
            let differences: Vec<f64> = this.iter().zip(first).map(|(this, first)| this - first).collect();
            let found = Estimate::of(&differences);
            Estimate { within_95: found.within_95.filter(|_| !sure), ..found }
        });
        Self { means: values.map(|values| values.map(|values| Estimate::of(&values).mean)), difference }
    }

    /// Whether the interval leaves out 0; where there is none because nothing is random, whether they differ.
    pub fn differs(&self) -> Option<bool> {
        self.difference.map(|found| found.mean.abs() > found.within_95.unwrap_or(0.0))
    }
}

#[cfg(test)]
#[path = "../tests/inside/paired.rs"]
mod tests;
