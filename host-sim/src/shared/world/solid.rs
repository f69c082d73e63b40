//! Objects of a world as core's shapes: what a hand presses on, and how stiff it is.

use haptic_core::contact::shape::{self, Edge};
use haptic_core::contact::{Contact, Side};
use haptic_core::settings::Settings;
use haptic_protocol::world::{Block, Shape, Strip, Wall};

use super::frame::Frame;

/// What the outline of an object that does not move encloses.
pub type Solid = shape::Shape<f64, [Edge<f64>; 4]>;

/// The corners of a wall, in order around it, m.
pub fn wall_corners(wall: &Wall) -> [[f64; 2]; 4] {
    let Frame { from, along, out, length } = Frame::new([wall.from_x_m, wall.from_y_m], [wall.to_x_m, wall.to_y_m]);
    let at = |x: f64, y: f64| [0, 1].map(|axis| from[axis] + x * along[axis] + y * out[axis]);
    let behind = -f64::from(wall.thickness_m);
    [at(0.0, 0.0), at(length, 0.0), at(length, behind), at(0.0, behind)]
}

/// The corners of a block, in order around it, m.
pub fn block_corners(block: &Block) -> [[f64; 2]; 4] {
    block.corners().map(|corner| corner.map(f64::from))
}

/// The solid of an object, or the strip that it is.
pub fn solid(shape: &Shape) -> Result<Solid, &Strip> {
    match shape {
        Shape::Body(body) => {
            let (centre, radius) = ([body.x_m, body.y_m].map(f64::from), f64::from(body.radius_m));
            Ok(Solid::Disc { centre, radius })
        }
        Shape::Wall(wall) => Ok(Solid::Polygon(shape::edges(wall_corners(wall)))),
        Shape::Block(block) => Ok(Solid::Polygon(shape::edges(block_corners(block)))),
        Shape::Strip(strip) => Err(strip),
    }
}

/// Contact stiffness, N/m, and contact damping, N·s/m, of an object.
pub fn gains(shape: &Shape) -> (f64, f64) {
    let (stiffness, damping) = match shape {
        Shape::Wall(wall) => (wall.stiffness_n_per_m, wall.damping_n_s_per_m),
        Shape::Body(body) => (body.stiffness_n_per_m, body.damping_n_s_per_m),
        Shape::Strip(strip) => (strip.stiffness_n_per_m, strip.damping_n_s_per_m),
        Shape::Block(block) => (block.stiffness_n_per_m, block.damping_n_s_per_m),
    };
    (f64::from(stiffness), f64::from(damping))
}

/// The contact of an object.
pub fn contact(shape: &Shape) -> Contact<f64> {
    let mut settings = Settings::default();
    settings.contact.one_sided = true;
    settings.contact.side = Side::Left;
    (settings.contact.stiffness_n_per_m, settings.contact.damping_n_s_per_m) = gains(shape);
    Contact::build(&settings)
}
