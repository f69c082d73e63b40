//! What the hand feels: the contact between the device and the local copy of the shared object.
//!
//! | module | holds |
//! |---|---|
//! | [`continuous`] | continuous rendering: a spring and a damper |
//! | [`impulsive`] | impulsive rendering: impacts between device and object, felt as pulses of one tick |
//! | [`impact`] | impacts of round bodies and flat walls: time of impact, exchange of momentum |
//! | [`bounder`] | stiffness and damping that follow the measured round trip |
//! | [`shape`] | polygons and discs in the plane: springs and dampers normal to their surface |

pub mod bounder;
pub mod continuous;
pub mod impact;
pub mod impulsive;
pub mod shape;

use crate::model::Model;
use crate::num::{Motion, Scalar};

pub use crate::names::{RenderingName, Side};
pub use continuous::Contact;
pub use impulsive::Strikes;

/// What contact does in one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Touch<S> {
    /// Force that pushes the object through this tick, N.
    pub pushing: S,
    /// Force on the object whose reaction the device feels, N.
    pub felt: S,
}

/// Impacts since arming, and what of them reached the hand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impacts<S> {
    /// Impacts.
    pub count: u32,
    /// Σ|ΔQ| exchanged with the object, N·s.
    pub wanted_n_s: S,
    /// What of it the limits of force and slew let through to the device, N·s.
    pub delivered_n_s: S,
    /// Energy that restitution below 1 took, J.
    pub lost_j: S,
}

/// A way to render contact. What it remembers is the same for all, so that a scene of springs pays for no other.
pub trait Rendering<S: Scalar>: Model<S> {
    /// Where an object must be put so that a device at `position` (m) does not touch it before it has crossed the gap.
    fn clear_of(&self, position: S) -> S;
    /// One tick: the contact of device and object, given the force (N) that the device was last commanded. Impacts move
    /// the object on.
    fn touch(&self, strikes: &mut Strikes<S>, device: Motion<S>, object: &mut Motion<S>, commanded: S) -> Touch<S>;
}

list! {
    /// Any way to render contact.
    AnyRendering, named by RenderingName in contact.rendering {
        Continuous(Contact<S>),
        Impulsive(impulsive::Impulsive<S>),
    }
}

impl<S: Scalar> AnyRendering<S> {
    /// [`Rendering::clear_of`].
    pub fn clear_of(&self, position: S) -> S {
        each!(self: Continuous | Impulsive, model => model.clear_of(position))
    }

    /// [`Rendering::touch`].
    #[inline]
    pub fn touch(&self, strikes: &mut Strikes<S>, device: Motion<S>, object: &mut Motion<S>, commanded: S) -> Touch<S> {
        each!(self: Continuous | Impulsive, model => model.touch(strikes, device, object, commanded))
    }
}
