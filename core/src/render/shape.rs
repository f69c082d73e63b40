//! A shape as several springs and dampers normal to its surface, in the plane (architectures paper §2.2, eq. 5 and 6).
//!
//! "In general, objects of complex shape can be modeled as a collection of springs and shock absorbers normal to the
//! surface." A [`Patch`] is one of them: a point of the surface, the outward normal there, and how far to either side it
//! reaches. Under it, with x the depth of the device below the surface and ẋ its rate,
//!
//! > F = K·x + B·ẋ if x > 0 else 0,   along the inward normal, on the object; the device feels the reaction.
//!
//! Patches act independently and their forces add up: at a corner two of them push. A patch holds a device no deeper than
//! its thickness, so that the one on the other side of a shape does not pull at it; through a shape that is pressed to
//! more than that, the device falls. The object translates and does not turn: the force moves it by m·ẍ + b·ẋ along each
//! axis ([`crate::object`]). F may pull for as long as x > 0, as in the paper. Units: m, m/s, N/m, N·s/m, N. NaN in: no
//! contact.

use crate::motion::Motion;
use crate::scalar::Scalar;

/// One spring and damper of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch<S> {
    /// Its middle, from the object's origin, m.
    pub point: [S; 2],
    /// Unit normal, out of the object.
    pub normal: [S; 2],
    /// How far it reaches along the surface to either side, m.
    pub reach: S,
    /// How deep it holds, m.
    pub thickness: S,
    /// K, N/m.
    pub stiffness: S,
    /// B, N·s/m.
    pub damping: S,
}

/// What a device feels of a shape.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pressed<S> {
    /// Force on the object along each axis, N; the device feels the reaction.
    pub force: [S; 2],
    /// Patches in contact.
    pub patches: u32,
    /// Energy in their springs, J.
    pub stored_j: S,
}

impl<S: Scalar> Patch<S> {
    /// Depth and its rate of a device at this distance from the patch, if it is under the patch.
    fn depth(&self, distance: [Motion<S>; 2]) -> Option<(S, S)> {
        let [x, y] = distance;
        let [nx, ny] = self.normal;
        let depth = -(nx * x.position + ny * y.position);
        let beside = (nx * y.position - ny * x.position).abs();
        let under = depth > S::ZERO && depth <= self.thickness && beside <= self.reach;
        under.then(|| (depth, -(nx * x.velocity + ny * y.velocity)))
    }
}

/// The force between a device and the shape made of `patches`, both at these places along the two axes.
pub fn press<S: Scalar>(patches: &[Patch<S>], device: [Motion<S>; 2], object: [Motion<S>; 2]) -> Pressed<S> {
    let mut pressed = Pressed::default();
    for patch in patches {
        let mut distance = device;
        for ((axis, object), point) in distance.iter_mut().zip(object).zip(patch.point) {
            axis.position = axis.position - object.position - point;
            axis.velocity = axis.velocity - object.velocity;
        }
        if let Some((depth, rate)) = patch.depth(distance) {
            let force = patch.stiffness * depth + patch.damping * rate;
            pressed.patches += 1;
            pressed.stored_j = pressed.stored_j + S::from_f64(0.5) * patch.stiffness * depth * depth;
            for (sum, normal) in pressed.force.iter_mut().zip(patch.normal) {
                *sum = *sum - force * normal;
            }
        }
    }
    pressed
}
