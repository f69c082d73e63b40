//! A shape in the plane as springs and dampers normal to its surface (architectures paper §2.2, eq. 5 and 6).
//!
//! "In general, objects of complex shape can be modeled as a collection of springs and shock absorbers normal to the
//! surface." Of the springs of one shape only the least compressed acts, the one to the nearest point of the surface:
//!
//! > F = K·x + B·ẋ if x > 0 else 0,   along the inward normal there, on the object; the device feels the reaction,
//!
//! with x the depth of the device below the surface and ẋ its rate: the [`Contact`] of the peer, along that normal. So
//! ½·K·x² is a continuous potential, and a walk around a closed path costs what the damper takes and nothing else. If
//! all springs pushed that have the device below them, it would not be: a device that comes through one side near a
//! corner would find the other side's spring compressed already, which is energy from nowhere. Different shapes act
//! independently and their forces add: two walls that meet in a corner both push.
//!
//! **Limits**: where two sides are equally near, behind a corner, the direction turns at once and the size does not. A
//! device is pushed out of the nearest side, not back to where it came from; and drawn around a sharp corner from inside, it
//! stays under the side that it comes from until the other one is as near. The object translates and does not turn: the
//! force moves it by m·ẍ + b·ẋ along each axis ([`cohold_core::object`]). F may pull for as long as x > 0, as in the paper.
//! Units: m, m/s, N. NaN in: no contact.

use cohold_core::contact::Contact;
use cohold_core::num::{Motion, Scalar};

/// A straight piece of an outline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge<S> {
    from: [S; 2],
    to: [S; 2],
    /// Unit vector; zero where the edge has no length.
    along: [S; 2],
    length: S,
}

/// Outline on which a device can press, in coordinates relative to the object's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape<S, Edges> {
    /// A polygon: each edge ends where the next begins, the last where the first begins, and none cross. Either
    /// direction round will do.
    Polygon(Edges),
    /// A disc, in contact inside its circle.
    Disc {
        /// Centre of the disc, m.
        centre: [S; 2],
        /// Radius of the disc, m.
        radius: S,
    },
}

/// Depth of a point inside a shape, and the normal of the nearest surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Depth<S> {
    /// Distance to the nearest surface, m; above 0.
    pub depth: S,
    /// Unit normal, out of the object.
    pub normal: [S; 2],
}

/// The contact of a device and a shape.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pressed<S> {
    /// Depth x of the device, m; 0 where there is no contact.
    pub depth: S,
    /// Rate at which the depth grows, ẋ, m/s.
    pub rate: S,
    /// Force on the object along each axis, N; the device feels the reaction.
    pub force: [S; 2],
}

fn minus<S: Scalar>(a: [S; 2], b: [S; 2]) -> [S; 2] {
    let ([ax, ay], [bx, by]) = (a, b);
    [ax - bx, ay - by]
}

fn dot<S: Scalar>(a: [S; 2], b: [S; 2]) -> S {
    let ([ax, ay], [bx, by]) = (a, b);
    ax * bx + ay * by
}

/// To the left of a direction.
fn left<S: Scalar>([x, y]: [S; 2]) -> [S; 2] {
    [-y, x]
}

impl<S: Scalar> Edge<S> {
    /// The edge between two corners, m.
    pub fn new(from: [f64; 2], to: [f64; 2]) -> Self {
        let way = minus(to, from);
        let length = libm::hypot(way[0], way[1]);
        let unit = |part: f64| S::from_f64(if length > 0.0 { part / length } else { 0.0 });
        let [from, to] = [from, to].map(|corner| corner.map(S::from_f64));
        Self { from, to, along: way.map(unit), length: S::from_f64(length) }
    }

    /// Whether a ray from the point toward positive x crosses this edge.
    fn is_crossed(&self, point: [S; 2]) -> bool {
        let ([_, y], [_, from], [_, to]) = (point, self.from, self.to);
        let beyond = dot(left(self.along), minus(point, self.from)) > S::ZERO;
        (from > y) != (to > y) && beyond == (to > from)
    }

    /// How far the point is from this edge, and the way there.
    fn nearest(&self, point: [S; 2]) -> (S, [S; 2]) {
        let from = minus(point, self.from);
        let along = dot(from, self.along);
        if along > S::ZERO && along < self.length {
            let beside = dot(from, left(self.along));
            let [x, y] = left(self.along);
            return (beside.abs(), if beside > S::ZERO { [-x, -y] } else { [x, y] });
        }
        away(minus(if along > S::ZERO { self.to } else { self.from }, point))
    }
}

/// Length and direction of a vector; one without length has no direction, and any will do.
fn away<S: Scalar>(way: [S; 2]) -> (S, [S; 2]) {
    let length = dot(way, way).sqrt();
    (length, if length > S::ZERO { way.map(|part| part.ratio(length)) } else { [S::ONE, S::ZERO] })
}

impl<S: Scalar, Edges: AsRef<[Edge<S>]>> Shape<S, Edges> {
    /// Depth of a point (m, relative to the object's origin) and the normal there; `None` outside.
    pub fn depth(&self, point: [S; 2]) -> Option<Depth<S>> {
        if !point.iter().all(|part| part.is_finite()) {
            return None;
        }
        let (depth, normal) = match self {
            Self::Disc { centre, radius } => {
                let (distance, normal) = away(minus(point, *centre));
                (*radius - distance, normal)
            }
            Self::Polygon(edges) => {
                let edges = edges.as_ref();
                let inside = edges.iter().filter(|edge| edge.is_crossed(point)).count() % 2 == 1;
                let ways = edges.iter().filter(|_| inside).map(|edge| edge.nearest(point));
                ways.reduce(|least, way| if way.0 < least.0 { way } else { least })?
            }
        };
        (depth > S::ZERO).then_some(Depth { depth, normal })
    }

    /// The contact of a device and this shape, from the motions of both along the two axes. `contact` must be
    /// one-sided, with the device on the left and no gap.
    pub fn press(&self, contact: &Contact<S>, device: [Motion<S>; 2], object: [Motion<S>; 2]) -> Pressed<S> {
        let place = minus(device.map(|axis| axis.position), object.map(|axis| axis.position));
        let Some(Depth { depth, normal }) = self.depth(place) else { return Pressed::default() };
        let away = minus(device.map(|axis| axis.velocity), object.map(|axis| axis.velocity));
        let rate = -dot(away, normal);
        if !rate.is_finite() {
            return Pressed::default();
        }
        let force = contact.force(Motion::new(depth, rate), Motion::REST);
        Pressed { depth, rate, force: normal.map(|part| -(force * part)) }
    }
}

/// The edges of a polygon with these corners, m.
pub fn edges<S: Scalar, const N: usize>(corners: [[f64; 2]; N]) -> [Edge<S>; N] {
    let next = |at: usize| if at.saturating_add(1) < N { at.saturating_add(1) } else { 0 };
    core::array::from_fn(|at| {
        let corner = |at: usize| corners.get(at).copied().unwrap_or_default();
        Edge::new(corner(at), corner(next(at)))
    })
}
