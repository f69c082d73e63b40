//! A mean over seeds, and how sure it is.

use cohold_sim::student::student_95;

/// A mean over seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Mean over the seeds.
    pub mean: f64,
    /// The true mean is that far from it at most, with 95 % confidence (Student); nothing of a single run.
    pub within_95: Option<f64>,
}

impl Estimate {
    /// The estimate from one value for each seed; without an interval where there is only one.
    pub fn of(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
        let within = || student_95(values.len() as u32 - 1) * (squares / (count - 1.0) / count).sqrt();
        Self { mean, within_95: (values.len() > 1).then(within) }
    }
}

#[cfg(test)]
#[path = "../tests/inside/estimate.rs"]
mod tests;
