//! A device whose mass couples its axes: rotors and links turn with its joints, and weigh in every direction as the mechanism has it.
//!
//! With m along every axis and J_m at every joint the mass in the task is M = m·1 + J⁻ᵀ·J_m·J⁻¹, J the Jacobian of the home pose: it is
//! taken for every pose, which is exact near home. What brakes and holds is the same along all axes, so along the principal axes of M each
//! is a mass of its own, advanced as exactly as one axis is.

use std::array::from_fn;

use cohold_core::num::Motion;

use super::linear::Linear;

/// Turns after which a matrix of three rows is diagonal by far: Jacobi's method squares what is left with every one.
const SWEEPS: usize = 12;

/// The principal axes of a device.
#[derive(Clone, Debug)]
pub(super) struct Principal<const N: usize> {
    /// Unit vectors.
    axes: [[f64; N]; N],
    linear: [Linear; N],
}

impl<const N: usize> Principal<N> {
    /// Of this mass matrix, kg; `moving` makes what a mass, kg, moves like.
    pub(super) fn new(mass: [[f64; N]; N], moving: impl Fn(f64) -> Linear) -> Self {
        let (masses, axes) = principal(mass);
        Self { axes, linear: masses.map(moving) }
    }

    /// The motions one step later under the forces before and now.
    pub(super) fn advance(&self, motions: [Motion<f64>; N], before: [f64; N], now: [f64; N]) -> [Motion<f64>; N] {
        let turned = |vector: [f64; N]| self.axes.map(|axis| dot(axis, vector));
        let (positions, velocities) = (turned(motions.map(|at| at.position)), turned(motions.map(|at| at.velocity)));
        let (before, now) = (turned(before), turned(now));
        let next: [Motion<f64>; N] = from_fn(|at| {
            let motion = Motion::new(positions[at], velocities[at]);
            self.linear[at].advance(motion, before[at], now[at])
        });
        from_fn(|axis| {
            let back = |of: &dyn Fn(&Motion<f64>) -> f64| (0..N).map(|at| self.axes[at][axis] * of(&next[at])).sum();
            Motion::new(back(&|motion| motion.position), back(&|motion| motion.velocity))
        })
    }
}

fn dot<const N: usize>(one: [f64; N], other: [f64; N]) -> f64 {
    one.iter().zip(&other).map(|(one, other)| one * other).sum()
}

/// The mass matrix of joints that weigh alike, kg or kg·m², in the task: their inverse Jacobian's columns with each other.
pub(super) fn in_the_task<const N: usize>(inverse: [[f64; N]; N], mass_kg: f64, at_joint: f64) -> [[f64; N]; N] {
    from_fn(|row| {
        from_fn(|column| {
            let joints = (0..N).map(|joint| inverse[joint][row] * inverse[joint][column]).sum::<f64>();
            at_joint * joints + if row == column { mass_kg } else { 0.0 }
        })
    })
}

/// Eigenvalues of a symmetric matrix, and their unit vectors, by Jacobi's rotations.
fn principal<const N: usize>(mut matrix: [[f64; N]; N]) -> ([f64; N], [[f64; N]; N]) {
    let mut axes: [[f64; N]; N] = from_fn(|row| from_fn(|column| f64::from(u8::from(row == column))));
    for _ in 0..SWEEPS {
        for (one, other) in (0..N).flat_map(|one| (one + 1..N).map(move |other| (one, other))) {
            let off = matrix[one][other];
            if off == 0.0 {
                continue;
            }
            let half_turn = 0.5 * (matrix[other][other] - matrix[one][one]) / off;
            let tangent = half_turn.signum() / (half_turn.abs() + half_turn.hypot(1.0));
            let cosine = 1.0 / tangent.hypot(1.0);
            let sine = tangent * cosine;
            let turn = |a: f64, b: f64| (cosine * a - sine * b, sine * a + cosine * b);
            for row in &mut matrix {
                (row[one], row[other]) = turn(row[one], row[other]);
            }
            for column in 0..N {
                (matrix[one][column], matrix[other][column]) = turn(matrix[one][column], matrix[other][column]);
                (axes[one][column], axes[other][column]) = turn(axes[one][column], axes[other][column]);
            }
            (matrix[one][other], matrix[other][one]) = (0.0, 0.0);
        }
    }
    (from_fn(|at| matrix[at][at]), axes)
}
