//! Recursive least squares of four parameters with forgetting: θ and P of [`super`].

use cohold_core::num::Scalar;

/// Recursive least squares of four parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Estimate<S> {
    /// Estimated parameters θ, each in its unit of [`super::UNITS`].
    pub(super) theta: [S; 4],
    /// Lower triangle of P, row by row.
    covariance: [S; 10],
}

/// Place of P's element in its triangle.
const fn at(i: usize, j: usize) -> usize {
    if i >= j { i * (i + 1) / 2 + j } else { j * (j + 1) / 2 + i }
}

impl<S: Scalar> Estimate<S> {
    /// Nothing is known but what it begins with; every variance is 1.
    pub(super) fn start(theta: [S; 4]) -> Self {
        let mut covariance = [S::ZERO; 10];
        for i in 0..4 {
            covariance[at(i, i)] = S::ONE;
        }
        Self { theta, covariance }
    }

    /// One packet: λ·R, R/1000 and 1/λ, the factors φ and the force, N.
    pub(super) fn learn(&mut self, [noise, least, forget]: [S; 3], factors: [S; 4], force: S) {
        let dot = |a: &[S; 4], b: &[S; 4]| a.iter().zip(b).fold(S::ZERO, |sum, (a, b)| sum + *a * *b);
        let mut seen = [S::ZERO; 4];
        for (i, seen) in seen.iter_mut().enumerate() {
            *seen = (0..4).fold(S::ZERO, |sum, j| sum + self.covariance[at(i, j)] * factors[j]);
        }
        let expected = dot(&factors, &seen);
        if expected < least {
            return;
        }
        let error = force - dot(&factors, &self.theta);
        let share = S::ONE.ratio(noise + expected);
        for i in 0..4 {
            let gain = seen[i] * share;
            self.theta[i] = self.theta[i] + gain * error;
            for (j, seen) in seen.iter().enumerate().take(i + 1) {
                self.covariance[at(i, j)] = (self.covariance[at(i, j)] - gain * *seen) * forget;
            }
        }
        for i in 0..4 {
            let variance = self.covariance[at(i, i)];
            if variance > S::ONE {
                let shrink = S::ONE.ratio(variance.sqrt());
                for j in 0..4 {
                    let both = if i == j { shrink * shrink } else { shrink };
                    self.covariance[at(i, j)] = self.covariance[at(i, j)] * both;
                }
            }
        }
    }
}
