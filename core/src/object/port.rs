//! A port: the mean force on the copy through one tick, with its dependence on the copy's velocity.
//!
//! Over a tick the mean force of a spring, a damper, a wall or a wave line is affine in the copy's mean velocity v,
//!
//! > F = f − z·v,   z ≥ 0,
//!
//! and two ports that push on one copy are again a port: f and z add up (THEORY §7). [`super::midpoint`] solves for v once,
//! whatever there is, and so does [`super::backward_euler`].

use core::ops::Add;

use crate::num::Scalar;
use crate::settings::Settings;

/// Mean force on the copy through one tick, as a function of its mean velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Port<S> {
    /// f: the force on a copy that stands still, N.
    pub force: S,
    /// z: by how much the force falls per m/s of the copy's mean velocity, N·s/m; never negative.
    pub impedance: S,
}

/// z of a spring (N/m) and damper (N·s/m) to a point that does not follow the copy: K·T_c/2 + B, N·s/m, for a force as it is midway
/// through the tick; K·T_c + B as the tick ends ([`super::backward_euler`]).
pub fn met_midway(stiffness: f64, damping: f64, settings: &Settings) -> f64 {
    settings.object.integrator.part_of_tick() * settings.timing.control_period_s * stiffness + damping
}

impl<S: Scalar> Port<S> {
    /// With this force at rest (N), which falls by the impedance (N·s/m) for each metre per second.
    #[inline(always)]
    pub const fn new(force: S, impedance: S) -> Self {
        Self { force, impedance }
    }

    /// A force that does not depend on how the copy moves, N.
    pub fn of_force(force: S) -> Self {
        Self::new(force, S::ZERO)
    }

    /// The force on a copy whose mean velocity (m/s) is this, N.
    #[inline]
    pub fn at(self, velocity: S) -> S {
        self.force - self.impedance * velocity
    }
}

/// Gives a law the velocity of the copy in a tick ([`crate::law::Law::couple`]): any closure from a port to a velocity,
/// which solves for everything that pushes on the copy at once, or [`Staged`].
pub trait Solve<S: Scalar> {
    /// Whether every force is found from the motion as the tick begins, in stages, as the papers have it. Known when the program is compiled:
    /// a branch on it costs nothing.
    fn is_staged(&self) -> bool;
    /// Velocity of the copy through the tick, m/s, that comes of this port and of whatever else pushes on the copy.
    fn velocity(self, port: Port<S>) -> S;
}

impl<S: Scalar, F: FnOnce(Port<S>) -> S> Solve<S> for F {
    #[inline(always)]
    fn is_staged(&self) -> bool {
        false
    }
    #[inline(always)]
    fn velocity(self, port: Port<S>) -> S {
        self(port)
    }
}

/// Forces are found one after the other, and the copy moves when all are known: its velocity (m/s) is the one that the tick begins with.
#[derive(Clone, Copy, Debug)]
pub struct Staged<S>(pub S);

impl<S: Scalar> Solve<S> for Staged<S> {
    #[inline(always)]
    fn is_staged(&self) -> bool {
        true
    }
    #[inline(always)]
    fn velocity(self, _: Port<S>) -> S {
        self.0
    }
}

impl<S: Scalar> Add for Port<S> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self { force: self.force + other.force, impedance: self.impedance + other.impedance }
    }
}
