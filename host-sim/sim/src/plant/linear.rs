//! Exact discretisation of m·ẍ + b·ẋ + k·x = F for a force that is constant in two pieces of one period.
//!
//! x⁺ = Φ(T)·x + [Γ(T) − Γ((1−τ)T)]·F_before + Γ((1−τ)T)·F_now, with (Φ, Γ) from the exponential of the 3×3 augmented
//! matrix [[A, B], [0, 0]]·t by scaling and squaring of its Taylor series (relative error < 1e-14).

use cohold_core::num::{Motion, Scalar};

/// A mass, damper and spring over one period.
#[derive(Clone, Debug)]
pub struct Linear<S = f64> {
    /// Φ(T), row by row: position, velocity.
    pub transition: [[S; 2]; 2],
    /// Position (m) and velocity (m/s) that each newton of the previous force adds.
    pub gain_before: [S; 2],
    /// Position (m) and velocity (m/s) that each newton of the present force adds.
    pub gain_now: [S; 2],
}

type Matrix = [[f64; 3]; 3];

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let mut c = [[0.0; 3]; 3];
    for (row, out) in a.iter().zip(&mut c) {
        for (j, cell) in out.iter_mut().enumerate() {
            *cell = row.iter().zip(b).map(|(x, line)| x * line[j]).sum();
        }
    }
    c
}

fn exponential(a: &Matrix, time: f64) -> Matrix {
    let norm = a.iter().flatten().map(|x| (x * time).abs()).sum::<f64>();
    let halvings = (libm::log2(norm.max(1e-300)).ceil() + 4.0).max(0.0) as i32;
    let scaled = a.map(|row| row.map(|x| x * time / libm::exp2(f64::from(halvings))));
    let identity: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // Horner: I + A(I + A/2(I + A/3(...))).
    let mut sum = identity;
    for k in (1..=14).rev() {
        sum = product(&scaled, &sum);
        for (row, unit) in sum.iter_mut().zip(&identity) {
            for (x, one) in row.iter_mut().zip(unit) {
                *x = *x / f64::from(k) + one;
            }
        }
    }
    for _ in 0..halvings {
        sum = product(&sum, &sum);
    }
    sum
}

impl Linear {
    /// A plant of this mass (kg), damping (N·s/m), stiffness (N/m), delay of the motor force (0 to 1 ticks) and period (s).
    pub fn new(mass: f64, damping: f64, stiffness: f64, delay_ticks: f64, period: f64) -> Self {
        let a: Matrix = [[0.0, 1.0, 0.0], [-stiffness / mass, -damping / mass, 1.0 / mass], [0.0, 0.0, 0.0]];
        let whole = exponential(&a, period);
        let fresh = exponential(&a, (1.0 - delay_ticks) * period);
        Self {
            transition: [[whole[0][0], whole[0][1]], [whole[1][0], whole[1][1]]],
            gain_before: [whole[0][2] - fresh[0][2], whole[1][2] - fresh[1][2]],
            gain_now: [fresh[0][2], fresh[1][2]],
        }
    }
}

impl<S: Scalar> Linear<S> {
    /// The motion one period later, under the previous and the present force, N.
    #[inline]
    pub fn advance(&self, motion: Motion<S>, before: S, now: S) -> Motion<S> {
        let line = |row: usize| {
            let [from_position, from_velocity] = self.transition[row];
            from_position * motion.position
                + from_velocity * motion.velocity
                + self.gain_before[row] * before
                + self.gain_now[row] * now
        };
        Motion::new(line(0), line(1))
    }
}
