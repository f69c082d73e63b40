//! Objects of a world as core's shapes: what a hand presses on, and how stiff it is; vectors in the plane.

use super::springs::{self, Edge};
use cohold_core::contact::{Contact, Side};
use cohold_core::settings::Settings;

use crate::records::{Block, Shape, Strip, Wall};

/// Along x and y.
pub(super) type Vector = [f64; 2];

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(super) fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1]]
}

/// A line with a free side on its left.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) from: Vector,
    pub(super) along: Vector,
    /// To the free side.
    pub(super) out: Vector,
    pub(super) length: f64,
}

impl Frame {
    pub(super) fn new(from: [f32; 2], to: [f32; 2]) -> Self {
        let from = from.map(f64::from);
        let offset = minus(to.map(f64::from), from);
        let length = libm::sqrt(dot(offset, offset));
        let along = offset.map(|part| part / length);
        Self { from, along, out: [-along[1], along[0]], length }
    }

    /// How far along the line and how far out a point is, m.
    pub(super) fn local(&self, point: Vector) -> Vector {
        let from = minus(point, self.from);
        [dot(from, self.along), dot(from, self.out)]
    }
}

/// What the outline of an object that does not move encloses.
pub(super) type Solid = springs::Shape<f64, [Edge<f64>; 4]>;

/// The corners of a wall, in order around it, m.
pub(super) fn wall_corners(wall: &Wall) -> [[f64; 2]; 4] {
    let Frame { from, along, out, length } = Frame::new([wall.from_x_m, wall.from_y_m], [wall.to_x_m, wall.to_y_m]);
    let at = |x: f64, y: f64| [0, 1].map(|axis| from[axis] + x * along[axis] + y * out[axis]);
    let behind = -f64::from(wall.thickness_m);
    [at(0.0, 0.0), at(length, 0.0), at(length, behind), at(0.0, behind)]
}

/// The corners of a block, in order around it, m.
pub(super) fn block_corners(block: &Block) -> [[f64; 2]; 4] {
    block.corners().map(|corner| corner.map(f64::from))
}

/// The corners of what has corners, in order around it, m.
pub fn corners(shape: &Shape) -> Vec<[f64; 2]> {
    match shape {
        Shape::Wall(wall) => wall_corners(wall).to_vec(),
        Shape::Block(block) => block_corners(block).to_vec(),
        Shape::Body(_) | Shape::Strip(_) => Vec::new(),
    }
}

/// The solid of an object, or the strip that it is.
pub(super) fn solid(shape: &Shape) -> Result<Solid, &Strip> {
    match shape {
        Shape::Body(body) => {
            let (centre, radius) = ([body.x_m, body.y_m].map(f64::from), f64::from(body.radius_m));
            Ok(Solid::Disc { centre, radius })
        }
        Shape::Wall(wall) => Ok(Solid::Polygon(springs::edges(wall_corners(wall)))),
        Shape::Block(block) => Ok(Solid::Polygon(springs::edges(block_corners(block)))),
        Shape::Strip(strip) => Err(strip),
    }
}

/// Contact stiffness, N/m, and contact damping, N·s/m, of an object.
pub(super) fn gains(shape: &Shape) -> (f64, f64) {
    let (stiffness, damping) = match shape {
        Shape::Wall(wall) => (wall.stiffness_n_per_m, wall.damping_n_s_per_m),
        Shape::Body(body) => (body.stiffness_n_per_m, body.damping_n_s_per_m),
        Shape::Strip(strip) => (strip.stiffness_n_per_m, strip.damping_n_s_per_m),
        Shape::Block(block) => (block.stiffness_n_per_m, block.damping_n_s_per_m),
    };
    (f64::from(stiffness), f64::from(damping))
}

/// The contact of an object.
pub(super) fn contact(shape: &Shape) -> Contact<f64> {
    let mut settings = Settings::default();
    settings.contact.one_sided = true;
    settings.contact.side = Side::Left;
    (settings.contact.stiffness_n_per_m, settings.contact.damping_n_s_per_m) = gains(shape);
    Contact::build(&settings)
}
