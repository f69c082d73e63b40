//! A mass in the plane or in space, moved by ports whose impedance is a small symmetric matrix.
//!
//! What pushes on a copy that moves along several axes has a mean force through a tick that is affine in the mean velocity v,
//!
//! > F = f − Z·v,   Z symmetric, v·Z·v ≥ 0,
//!
//! and the midpoint rule of [`super::midpoint`] is one solve of as many equations: (2m/T_c + b + ΣZ)·v = 2m/T_c·ẋ + Σf, x ← x + T_c·v,
//! ẋ ← 2v − ẋ. ½·m·ẋ² changes by exactly T_c·(ΣF·v − b·v²), so what no damper takes is neither made nor lost, whatever couples the axes.
//! A law, a contact or a guide that knows one axis only is one entry of the diagonal.
//!
//! The matrix is positive definite, so that elimination without exchange of rows is stable (Higham, "Accuracy and Stability of Numerical
//! Algorithms", 2nd ed., 2002, §10.1). Units: N, N·s/m, m, m/s.

use core::ops::Add;

use super::port::Port;
use crate::num::{Carry, Motion, Scalar};

/// Mean force on a body through one tick, as a function of its mean velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VectorPort<S, const N: usize> {
    /// f: the force on a body that stands still, N.
    pub force: [S; N],
    /// Z: by how much the force falls per m/s of the body, N·s/m, row by row; symmetric.
    pub impedance: [[S; N]; N],
}

impl<S: Scalar, const N: usize> Default for VectorPort<S, N> {
    fn default() -> Self {
        Self { force: [S::ZERO; N], impedance: [[S::ZERO; N]; N] }
    }
}

impl<S: Scalar, const N: usize> VectorPort<S, N> {
    /// Independent ports along each axis: Z is diagonal.
    pub fn of_axes(ports: [Port<S>; N]) -> Self {
        let mut impedance = [[S::ZERO; N]; N];
        for (at, (row, port)) in impedance.iter_mut().zip(&ports).enumerate() {
            if let Some(own) = row.get_mut(at) {
                *own = port.impedance;
            }
        }
        Self { force: ports.map(|port| port.force), impedance }
    }

    /// A port that acts along this unit vector only.
    pub fn along(unit: [S; N], port: Port<S>) -> Self {
        Self {
            force: unit.map(|part| part * port.force),
            impedance: unit.map(|row| unit.map(|column| row * column * port.impedance)),
        }
    }

    /// The force on a body whose mean velocity (m/s) is this, N.
    pub fn at(&self, velocity: [S; N]) -> [S; N] {
        combined(self.force, times(&self.impedance, velocity), |force, resisted| force - resisted)
    }
}

impl<S: Scalar, const N: usize> Add for VectorPort<S, N> {
    type Output = Self;
    fn add(mut self, other: Self) -> Self {
        self.force = combined(self.force, other.force, |one, two| one + two);
        for (row, more) in self.impedance.iter_mut().zip(other.impedance) {
            *row = combined(*row, more, |one, two| one + two);
        }
        self
    }
}

/// The vector whose entries are `of` the entries of both.
pub(super) fn combined<S: Scalar, const N: usize>(mut one: [S; N], other: [S; N], of: impl Fn(S, S) -> S) -> [S; N] {
    for (one, other) in one.iter_mut().zip(other) {
        *one = of(*one, other);
    }
    one
}

pub(super) fn dot<S: Scalar, const N: usize>(one: [S; N], other: [S; N]) -> S {
    combined(one, other, |one, other| one * other).into_iter().fold(S::ZERO, |sum, part| sum + part)
}

pub(super) fn times<S: Scalar, const N: usize>(rows: &[[S; N]; N], vector: [S; N]) -> [S; N] {
    rows.map(|row| dot(row, vector))
}

/// x of A·x = right, A symmetric and positive definite; 0 along what A does not reach.
pub(super) fn solved<S: Scalar, const N: usize>(mut rows: [[S; N]; N], mut right: [S; N]) -> [S; N] {
    let entry = |row: &[S; N], at: usize| row.get(at).copied().unwrap_or(S::ZERO);
    for at in 0..N {
        let (Some(pivot), known) = (rows.get(at).copied(), entry(&right, at)) else { break };
        for (row, value) in rows.iter_mut().zip(&mut right).skip(at + 1) {
            let share = entry(row, at).ratio(entry(&pivot, at));
            *row = combined(*row, pivot, |below, above| below - share * above);
            *value = *value - share * known;
        }
    }
    let mut unknown = [S::ZERO; N];
    for at in (0..N).rev() {
        // What is not known yet is 0.
        if let Some(row) = rows.get(at) {
            let found = (entry(&right, at) - dot(*row, unknown)).ratio(entry(row, at));
            if let Some(unknown) = unknown.get_mut(at) {
                *unknown = found;
            }
        }
    }
    unknown
}

/// A mass with damping that is moved by [`VectorPort`]s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body<S, const N: usize> {
    period: S,
    /// m/(θ·T_c), N·s/m: 2m/T_c, or m/T_c with backward Euler.
    inertia: S,
    /// b, N·s/m.
    damping: S,
    /// θ, and 1/θ.
    part: S,
    whole: S,
    one_half: S,
}

configured!([S: Scalar, const N: usize] Body<S, N> { period, inertia, damping, part, whole, one_half });

/// Position and velocity of a body along every axis, with the rounding errors that they still owe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moving<S, const N: usize> {
    /// Position (m) and velocity (m/s) along each axis.
    pub axes: [Motion<S>; N],
    carries: [[Carry<S>; 2]; N],
}

impl<S: Scalar, const N: usize> Moving<S, N> {
    /// A body with these positions (m) and velocities (m/s).
    pub fn at(axes: [Motion<S>; N]) -> Self {
        Self { axes, carries: [[Carry::default(); 2]; N] }
    }

    /// Velocity along each axis, m/s.
    pub fn velocity(&self) -> [S; N] {
        self.axes.map(|axis| axis.velocity)
    }
}

visited!([S: Scalar, const N: usize] Moving<S, N> { axes });

impl<S: Scalar, const N: usize> Body<S, N> {
    /// A body of this mass (kg, above 0) and damping (N·s/m), in ticks of `period_s` (s).
    pub fn new(mass_kg: f64, damping_n_s_per_m: f64, period_s: f64) -> Self {
        Self::moved_within(0.5, mass_kg, damping_n_s_per_m, period_s)
    }

    /// The same, with its velocity taken through this part θ of a tick: ½ is the midpoint rule, 1 backward Euler.
    pub(super) fn moved_within(part: f64, mass_kg: f64, damping_n_s_per_m: f64, period_s: f64) -> Self {
        Self {
            period: S::from_f64(period_s),
            inertia: S::from_f64(mass_kg / part / period_s),
            damping: S::from_f64(damping_n_s_per_m),
            part: S::from_f64(part),
            whole: S::from_f64(1.0 / part),
            one_half: S::from_f64(0.5),
        }
    }

    /// The equations of a tick, A·v = r, under these ports.
    pub(super) fn equations(&self, moving: &Moving<S, N>, ports: &VectorPort<S, N>) -> ([[S; N]; N], [S; N]) {
        let mut rows = ports.impedance;
        for (at, row) in rows.iter_mut().enumerate() {
            if let Some(own) = row.get_mut(at) {
                *own = *own + self.inertia + self.damping;
            }
        }
        (rows, combined(ports.force, moving.velocity(), |force, velocity| force + self.inertia * velocity))
    }

    /// Mean velocity (m/s) of the body through a tick under `ports`, the sum of all ports on it.
    pub fn mean_velocity(&self, moving: &Moving<S, N>, ports: &VectorPort<S, N>) -> [S; N] {
        let (rows, right) = self.equations(moving, ports);
        solved(rows, right)
    }

    /// Advances the body by one control period at this mean velocity, m/s.
    pub fn advance(&self, moving: &mut Moving<S, N>, mean_velocity: [S; N]) {
        for ((axis, [position, velocity]), mean) in moving.axes.iter_mut().zip(&mut moving.carries).zip(mean_velocity) {
            let part_of_change = mean - axis.velocity;
            axis.position = position.add(axis.position, self.period * mean);
            axis.velocity = velocity.add(axis.velocity, self.whole * part_of_change);
        }
    }

    /// Kinetic energy of the body, J.
    pub fn energy_j(&self, moving: &Moving<S, N>) -> S {
        let velocity = moving.velocity();
        self.one_half * self.part * self.inertia * self.period * dot(velocity, velocity)
    }
}
