//! The local copy of the shared virtual object (SVO): m_O·ẍ_o + b_O·ẋ_o = F, advanced by one tick.
//!
//! Staged integrators take a force that was computed before; [`midpoint`] solves for all forces and the motion at once, and so does
//! [`backward_euler`]. Staged forces may act late: with a delay of τ ticks (0…1) the old force acts for τ·T_c and the new one for the
//! rest. A body that turns has a midpoint rule of its own, [`rigid`]. [`fixture`] is a guide or a wall at the copy, as another port. In the plane and in space ports
//! are matrices ([`vector`]), a wall with friction has any normal ([`plane`]), and a body moves and turns at once ([`free_body`], which
//! no peer uses yet). A new integrator is one file here, its `pub mod`, its name and one line in the list.

pub mod backward_euler;
pub mod euler;
pub mod exact;
pub mod fixture;
pub mod free_body;
pub mod midpoint;
pub mod plane;
pub mod port;
pub mod rigid;
pub mod vector;

use crate::model::Model;
use crate::num::{Carry, Motion, Scalar};

pub use crate::names::IntegratorName;
pub use port::{Port, Solve, Staged};

/// Advances a mass by one tick.
pub trait Integrator<S: Scalar>: Model<S> {
    /// The motion one control period later, under `force` (N) and the force of the tick before, as far as that still acts.
    fn step(&self, before: &mut Self::State, motion: Motion<S>, force: S) -> Motion<S>;
}

list! {
    /// Any integrator, with what it remembers.
    AnyIntegrator, named by IntegratorName in object.integrator {
        ForwardEuler(euler::ForwardEuler<S>),
        SemiImplicit(euler::SemiImplicit<S>),
        Exact(exact::Exact<S>),
        Midpoint(midpoint::Midpoint<S>),
        BackwardEuler(backward_euler::BackwardEuler<S>),
    }
}

impl IntegratorName {
    /// Whether everything that pushes on the copy is a [`Port`], solved for with the motion of the tick; else forces come one after the other.
    pub const fn solves(self) -> bool {
        matches!(self, Self::Midpoint | Self::BackwardEuler)
    }

    /// θ: through which part of a tick the copy and its springs have moved where their forces are taken.
    pub(crate) const fn part_of_tick(self) -> f64 {
        match self {
            Self::BackwardEuler => 1.0,
            _ => 0.5,
        }
    }
}

impl<S: Scalar> AnyIntegrator<S> {
    /// The copy's motion after one tick under this force (N) ([`Integrator::step`]).
    #[inline]
    pub fn step(&mut self, motion: Motion<S>, force: S) -> Motion<S> {
        each!(self: ForwardEuler | SemiImplicit | Exact | Midpoint | BackwardEuler, model, before => model.step(before, motion, force))
    }

    /// Forgets the force of the tick before, as after [`AnyIntegrator::build`].
    pub fn rest(&mut self) {
        each!(self: ForwardEuler | SemiImplicit | Exact | Midpoint | BackwardEuler, _model, before => *before = Default::default());
    }
}

/// State of a staged integrator: the force of the tick before (N), and the rounding error that its last position
/// still owes (m).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Before<S> {
    /// Force of the tick before, N.
    force: S,
    /// Rounding, no state: nothing depends on it but the last bit.
    carry: Carry<S>,
}

visited!([S: Scalar] Before<S> { force });
