//! Discretisation of ẋ = A·x + b·F for a force that is held, by the diagonal Padé approximant of the matrix exponential.
//!
//! e^X ≈ q(X/2ˢ)⁻¹·p(X/2ˢ), squared s times, of order (6, 6) with ‖X‖ ≤ ½ after scaling: relative error below 1e-16
//! (Golub & Van Loan, §9.3).

use crate::matrix::{Matrix, rows};

/// The matrix exponential e^X of `matrix`.
pub fn exponential(matrix: &Matrix) -> Matrix {
    let size = matrix.nrows();
    let norm = matrix.column_iter().map(|column| column.iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
    let halvings = if norm > 0.5 { norm.log2().ceil() as i32 + 1 } else { 0 };
    let scaled = matrix * 0.5_f64.powi(halvings);
    let (mut above, mut below) = (Matrix::identity(size, size), Matrix::identity(size, size));
    let mut power = Matrix::identity(size, size);
    let mut weight = 1.0;
    for k in 1..=6 {
        let order = f64::from(k);
        weight *= (7.0 - order) / (order * (13.0 - order));
        power = &scaled * &power;
        above += &power * weight;
        below += &power * if k % 2 == 0 { weight } else { -weight };
    }
    below.lu().solve_mut(&mut above);
    for _ in 0..halvings {
        above = &above * &above;
    }
    above
}

/// A mass, damper and spring over one tick, with a force that may act late.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Held {
    /// Position and velocity after, for position and velocity before.
    pub motion: [[f64; 2]; 2],
    /// Position and velocity after, for the force of the tick before, per N.
    pub before: [f64; 2],
    /// Position and velocity after, for the force of this tick, per N.
    pub now: [f64; 2],
}

impl Held {
    /// Exact: the old force for `late` of the period, then the new one. Mass kg, damping N·s/m, stiffness N/m, period s.
    pub(crate) fn exact(mass: f64, damping: f64, stiffness: f64, late: f64, period: f64) -> Self {
        let over = |time: f64| {
            exponential(&rows([
                [0.0, time, 0.0],
                [-stiffness / mass * time, -damping / mass * time, time / mass],
                [0.0, 0.0, 0.0],
            ]))
        };
        let (first, second) = (over(late * period), over((1.0 - late) * period));
        let both = &second * &first;
        let carried = |i: usize| second[(i, 0)] * first[(0, 2)] + second[(i, 1)] * first[(1, 2)];
        Self {
            motion: [[both[(0, 0)], both[(0, 1)]], [both[(1, 0)], both[(1, 1)]]],
            before: [carried(0), carried(1)],
            now: [second[(0, 2)], second[(1, 2)]],
        }
    }

    /// Forward Euler: v⁺ = v + (T/m)·(F − b·v), x⁺ = x + T·v, with F = late·F_before + (1 − late)·F_now.
    pub(crate) fn forward_euler(mass: f64, damping: f64, late: f64, period: f64) -> Self {
        let gain = period / mass;
        Self {
            motion: [[1.0, period], [0.0, 1.0 - gain * damping]],
            before: [0.0, gain * late],
            now: [0.0, gain * (1.0 - late)],
        }
    }

    /// Semi-implicit Euler: the same velocity, and x⁺ = x + T·v⁺.
    pub(crate) fn semi_implicit(mass: f64, damping: f64, late: f64, period: f64) -> Self {
        let mut held = Self::forward_euler(mass, damping, late, period);
        held.motion[0][1] = period * held.motion[1][1];
        held.before[0] = period * held.before[1];
        held.now[0] = period * held.now[1];
        held
    }
}

#[cfg(test)]
#[path = "../../../tests/inside/lifted_constructed_hold.rs"]
mod tests;
