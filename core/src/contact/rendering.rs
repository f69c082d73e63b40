//! The trait of contact renderings and what they return: forces, and the account of impacts.

use crate::model::Model;
use crate::num::{Motion, Scalar, Sum};
use crate::object::Port;
use crate::safety::Limits;

/// Forces of the contact in one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Touch<S> {
    /// Force that pushes the object through this tick, N.
    pub pushing: S,
    /// Force on the object whose reaction the device feels, N.
    pub felt: S,
}

/// Forces of the contact in one tick of a copy that is moved by ports.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Press<S> {
    /// The port that pushes the object.
    pub port: Port<S>,
    /// Sign of the only force that the port may have on the object; 0: either sign.
    pub toward: S,
    /// Pulse: force on the object, beside that of the port, whose reaction the device feels, N.
    pub pulse: S,
}

/// Impacts since arming, and how much of their impulse reached the hand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impacts<S> {
    /// Number of impacts since arming.
    pub count: u32,
    /// Sum of the impulses that the impacts ask for Σ|ΔQ|, N·s.
    pub wanted_n_s: S,
    /// The part of that impulse that device and object have taken so far, within the limits of force and slew, N·s. The
    /// rest is still to come, or was not needed because somebody pulled them apart.
    pub delivered_n_s: S,
    /// Energy that restitution below 1 took, J.
    pub lost_j: S,
}

/// What a device can give in a tick: its limits, and the force (N) that it was commanded last.
pub type Giving<'a, S> = (&'a Limits<S>, S);

/// A rendering of contact. All renderings share one type of state, so that a scene of springs does not pay for
/// another.
pub trait Rendering<S: Scalar>: Model<S> {
    /// Position (m) at which to put an object so that a device at `position` (m) does not touch it before crossing the gap.
    fn clear_of(&self, position: S) -> S;
    /// One tick: the forces of contact between device and object, given what the device can give, and the object's motion. An
    /// impact changes that, by as much as the limits let the device feel of it; those of springs are the peer's matter.
    fn touch(
        &self,
        strikes: &mut Strikes<S>,
        device: Motion<S>,
        object: Motion<S>,
        giving: Giving<'_, S>,
    ) -> (Motion<S>, Touch<S>);
    /// [`Rendering::touch`] where the copy is moved by ports: the contact is a port of the copy, and the impacts'
    /// force on the device.
    fn press(
        &self,
        strikes: &mut Strikes<S>,
        device: Motion<S>,
        object: Motion<S>,
        giving: Giving<'_, S>,
    ) -> (Motion<S>, Press<S>);
}

/// State of impulsive contact, and the account of its impacts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Strikes<S> {
    /// Where device and object were at the last tick, m; none before the first.
    pub(super) before: Option<[S; 2]>,
    /// Ticks until nothing tells of the last pulse or push any more.
    pub(super) recent: u32,
    /// What the object is still to take of an impact, N·s.
    pub(super) owed: S,
    /// How fast they part after it, m/s.
    pub(super) rebound: S,
    /// Contact is a spring until they part.
    pub(super) resting: bool,
    pub(super) count: u32,
    pub(super) wanted: Sum<S>,
    pub(super) delivered: Sum<S>,
    pub(super) lost: Sum<S>,
}

impl<S: Scalar> Strikes<S> {
    /// Impacts so far; none where contact is continuous.
    pub fn impacts(&self) -> Impacts<S> {
        Impacts {
            count: self.count,
            wanted_n_s: self.wanted.total(),
            delivered_n_s: self.delivered.total(),
            lost_j: self.lost.total(),
        }
    }
}
