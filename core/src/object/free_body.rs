//! A rigid body that moves and turns: translation beside rotation, six equations solved at once.
//!
//! A port pushes on both: its force and torque through a tick are f − Z·(v, ω), v the mean velocity of the centre, ω the mean angular
//! velocity, both in space, Z six by six and symmetric. One that acts at a point r from the centre is Xᵀf − XᵀZX·(v, ω) with X = (1, −r×), and couples the two
//! ([`at_point`]). Translation follows [`super::vector`], rotation [`super::rigid`]: with A = 2m/T_c + b + Z_vv the first is
//! v = A⁻¹·(r_v − Z_vω·ω), which leaves of the port a torque alone,
//!
//! > τ = f_ω − Z_ωv·A⁻¹·r_v − (Z_ωω − Z_ωv·A⁻¹·Z_vω)·ω
//!
//! whose impedance is the Schur complement, symmetric and as passive as Z is. So the one nonlinear solve stays one of three equations.
//!
//! **Conserved**: what both parts conserve. Energy changes by exactly T_c·(F·v + τ·ω − b·v²), momentum by T_c·F,
//! angular momentum about the centre by T_c·τ. The place r at which a port acts is that of the tick's start: a spring
//! tied to a point that turns by T_c·ω in a tick stores its energy to that order.

use super::rigid::{Rotor, Three, TorquePort, Turned, Turning};
use super::vector::{Body, Moving, VectorPort, combined, dot, solved, times};
use crate::num::Scalar;

/// Force (N) and torque about the centre (N·m), as functions of the velocity of the centre (m/s) and the angular velocity (rad/s).
pub type Wrench<S> = VectorPort<S, 6>;

/// The wrench of a port at a point this far from the centre, m, in space.
pub fn at_point<S: Scalar>([x, y, z]: Three<S>, port: &VectorPort<S, 3>) -> Wrench<S> {
    let (one, no) = (S::ONE, S::ZERO);
    // X, by which the point moves: v + ω×r.
    let moves = [[one, no, no, no, z, -y], [no, one, no, -z, no, x], [no, no, one, y, -x, no]];
    let back = |vector: Three<S>| {
        let parts = moves.iter().zip(vector).map(|(row, part)| row.map(|entry| entry * part));
        parts.fold([no; 6], |sum, part| combined(sum, part, |one, other| one + other))
    };
    // Column by column, which are rows of what is symmetric.
    let mut impedance = [[no; 6]; 6];
    for (at, row) in impedance.iter_mut().enumerate() {
        let column = moves.map(|row| row.get(at).copied().unwrap_or(no));
        *row = back(times(&port.impedance, column));
    }
    Wrench { force: back(port.force), impedance }
}

/// Position, orientation and momenta of a rigid body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flying<S> {
    /// Position (m) and velocity (m/s) of the centre.
    pub moving: Moving<S, 3>,
    /// Orientation, and angular momentum.
    pub turning: Turning<S>,
}

visited!([S: Scalar] Flying<S> { moving, turning });

/// What the body did in a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flown<S> {
    /// Mean velocity of the centre through the tick v, m/s.
    pub mean_velocity: Three<S>,
    /// Mean angular velocity ω (rad/s) and torque τ (N·m) through the tick.
    pub turned: Turned<S>,
}

/// A rigid body without constraints: six degrees of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeBody<S> {
    /// Mass and damping of the translation.
    pub body: Body<S, 3>,
    /// Inertia of the rotation.
    pub rotor: Rotor<S>,
}

/// The first or the second three of six.
fn three<S: Scalar>(six: &[S; 6], from: usize) -> Three<S> {
    let mut part = [S::ZERO; 3];
    for (part, number) in part.iter_mut().zip(six.iter().skip(from)) {
        *part = *number;
    }
    part
}

/// Rows of a block of three by three.
fn block<S: Scalar>(port: &Wrench<S>, row: usize, column: usize) -> [Three<S>; 3] {
    let mut rows = [[S::ZERO; 3]; 3];
    for (out, whole) in rows.iter_mut().zip(port.impedance.iter().skip(row)) {
        *out = three(whole, column);
    }
    rows
}

impl<S: Scalar> FreeBody<S> {
    /// A body of this mass (kg), damping of its translation (N·s/m) and these principal moments of inertia (kg·m²),
    /// in ticks of `period_s` (s).
    pub fn new(mass_kg: f64, damping_n_s_per_m: f64, inertia_kg_m2: Three<f64>, period_s: f64) -> Self {
        Self { body: Body::new(mass_kg, damping_n_s_per_m, period_s), rotor: Rotor::new(inertia_kg_m2, period_s) }
    }

    /// Advances the body by one tick under `port`, the sum of all wrenches on it.
    pub fn step(&self, flying: &mut Flying<S>, port: &Wrench<S>) -> Flown<S> {
        let moves = VectorPort { force: three(&port.force, 0), impedance: block(port, 0, 0) };
        let (rows, right) = self.body.equations(&flying.moving, &moves);
        // Of a symmetric matrix: the rows of Z_ωv are the columns of Z_vω.
        let across = block(port, 3, 0);
        let answers = across.map(|column| solved(rows, column));
        let unturned = solved(rows, right);
        let mut impedance = block(port, 3, 3);
        for (row, coupling) in impedance.iter_mut().zip(across) {
            *row = combined(*row, answers.map(|answer| dot(coupling, answer)), |own, through| own - through);
        }
        let torque = combined(three(&port.force, 3), times(&across, unturned), |torque, moved| torque - moved);
        let turned = self.rotor.step(&mut flying.turning, &TorquePort { torque, impedance });
        let mut mean_velocity = unturned;
        for (answer, turns) in answers.into_iter().zip(turned.mean_velocity) {
            mean_velocity = combined(mean_velocity, answer, |mean, answer| mean - turns * answer);
        }
        self.body.advance(&mut flying.moving, mean_velocity);
        Flown { mean_velocity, turned }
    }

    /// Kinetic energy of translation and rotation, J.
    pub fn energy_j(&self, flying: &Flying<S>) -> S {
        self.body.energy_j(&flying.moving) + self.rotor.energy_j(&flying.turning)
    }
}
