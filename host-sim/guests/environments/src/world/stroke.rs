//! A hand that strokes along the outline of an object and pushes it about: what it feels, and where its work goes.
//!
//! The object is a solid of a world that translates by m·ẍ + b·ẋ = F along both axes (architectures paper §2.2), the force
//! that of [`super::springs`], both bodies moved by core's semi-implicit integrator. The person holds the hand by a
//! spring and a damper (an arm) at a point that goes, at constant speed relative to the object, from outside to a line at
//! [`Options::below_m`] under the surface, once around along that line, and out again. So on a side the hand is as deep as
//! the arm's spring k and the contact's K share that way: d = b/(1 + K/k), with b the way of the arm under the surface.
//!
//! **Corners** of less than 180° hold on to the hand: drawn around one from inside, it stays under the side that it comes from
//! until the other one is as near, which at an angle θ is at the depth b/(1 − (K/k)·cos θ) ([`SideResult::leaves_at_m`]). Where
//! K·cos θ ≥ k the arm is too soft and never draws it away: sharp corners want soft contacts.
//!
//! **Energy**: what the arm's far end does, ∫F·dx, is what springs and bodies hold at the end, plus what the dampers took.
//! Losses are summed with the velocities in the middle of each tick; what remains is of first order in the period.
//! Units: SI.

use cohold_core::object::{Before, Integrator};
use cohold_core::{model::Model as _, num::Motion, object::euler::SemiImplicit, settings::Settings};
use cohold_report::Columns;
use cohold_sim::quantities::Named;
use serde::Serialize;

use super::solid::{Vector, block_corners, contact, dot, gains, minus, solid, wall_corners};
use crate::Error;
use crate::records::Shape;

fn add(a: Vector, share: f64, b: Vector) -> Vector {
    [a[0] + share * b[0], a[1] + share * b[1]]
}

fn size(a: Vector) -> f64 {
    libm::hypot(a[0], a[1])
}

/// Mass, depth, speed and period of a stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Mass of the object, kg.
    pub mass_kg: f64,
    /// Its viscous damping, N·s/m.
    pub drag_n_s_per_m: f64,
    /// How far under the surface the arm's far end goes, m.
    pub below_m: f64,
    /// How fast it goes, m/s.
    pub speed_m_per_s: f64,
    /// Control period of the hand, s.
    pub period_s: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            mass_kg: 0.3,
            drag_n_s_per_m: 20.0,
            below_m: 0.003,
            speed_m_per_s: 0.05,
            period_s: super::CONTROL_PERIOD_S,
        }
    }
}

/// The hand's mass, kg, and its damping, N·s/m: those of the cooperation paper's device.
pub const HAND: (f64, f64) = (0.1, 1.0);
/// The arm's stiffness, N/m, and damping, N·s/m.
pub const ARM: (f64, f64) = (2000.0, 20.0);
/// Corners of the polygon along which the arm's far end goes around a disc.
const AROUND: usize = 360;

/// Columns of the record, one row a control period.
pub const COLUMNS: [Named; 8] = [
    ("way_m", "how far the arm's far end has gone"),
    ("hand_x_m", "position of the hand beside the object, along x"),
    ("hand_y_m", "position of the hand beside the object, along y"),
    ("force_x_n", "contact force on the hand, along x"),
    ("force_y_n", "contact force on the hand, along y"),
    ("depth_m", "how far the hand is below the surface"),
    ("object_x_m", "how far the object was pushed along x"),
    ("object_y_m", "how far the object was pushed along y"),
];

/// What was felt while the arm went along one side.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SideResult {
    /// `a-b`: the side from corner a to corner b; `rim`: a disc's.
    pub side: String,
    /// Angle inside the object at the side's first corner, degrees; none of a disc.
    pub corner_deg: Option<f64>,
    /// How deep the hand is, slowly, when that corner lets go of it, m; none where it does not hold, or never lets go.
    pub leaves_at_m: Option<f64>,
    /// Largest depth of the hand, m.
    pub largest_depth_m: f64,
    /// Largest force on the hand, N.
    pub largest_force_n: f64,
    /// Force where the arm leaves the side, N.
    pub last_force_n: f64,
}

/// Where the work went, J.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Energy {
    /// Done by the person.
    pub work_j: f64,
    /// In the springs of contact and arm at the end.
    pub stored_j: f64,
    /// In the motion of hand and object at the end.
    pub moving_j: f64,
    /// Taken by the contact's damper.
    pub contact_j: f64,
    /// Taken by the object's drag.
    pub drag_j: f64,
    /// Taken by the dampers of arm and hand.
    pub arm_j: f64,
}

impl Energy {
    /// What the time step leaves open, J.
    pub fn remainder_j(&self) -> f64 {
        self.work_j - self.stored_j - self.moving_j - self.contact_j - self.drag_j - self.arm_j
    }
}

/// A stroke around an object.
#[derive(Clone, Debug)]
pub struct Stroke {
    /// The outline, seen from the object, m; closed.
    pub(crate) outline: Vec<Vector>,
    /// What was felt where.
    pub parts: Vec<SideResult>,
    /// Energy balance of the stroke, J.
    pub energy: Energy,
    /// Every tick: how far the arm's far end has come; where the hand is, seen from the object, the force on it and its depth;
    /// where the object is.
    pub table: Columns,
}

/// A line through points; between each two of them lies the part with this number, or none.
struct Path {
    points: Vec<Vector>,
    parts: Vec<Option<usize>>,
}

impl Path {
    /// Where, how fast and along what one is after `travel_m`.
    fn at(&self, travel_m: f64, speed: f64) -> (Vector, Vector, Option<usize>) {
        let mut left = travel_m;
        for (pair, part) in self.points.windows(2).zip(&self.parts) {
            let edge = minus(pair[1], pair[0]);
            let length = size(edge);
            if left < length {
                return (add(pair[0], left / length, edge), edge.map(|axis| speed * axis / length), *part);
            }
            left -= length;
        }
        (self.points.last().copied().unwrap_or_default(), [0.0; 2], None)
    }

    fn length(&self) -> f64 {
        self.points.windows(2).map(|pair| size(minus(pair[1], pair[0]))).sum()
    }
}

/// The corners of the object's outline with their names; of a disc, those of a polygon without names.
fn outline(shape: &Shape) -> Vec<(Vector, &'static str)> {
    let corners = match shape {
        Shape::Wall(wall) => wall_corners(wall),
        Shape::Block(block) => block_corners(block),
        Shape::Body(body) => {
            let corner = |at: usize| {
                let (sine, cosine) = (std::f64::consts::TAU * at as f64 / AROUND as f64).sin_cos();
                let reach = f64::from(body.radius_m);
                [f64::from(body.x_m) + reach * cosine, f64::from(body.y_m) + reach * sine]
            };
            return (0..AROUND).map(|at| (corner(at), "")).collect();
        }
        Shape::Strip(_) => return Vec::new(),
    };
    let mut all: Vec<(Vector, &str)> = corners.into_iter().zip(["a", "b", "c", "d"]).collect();
    // Where two neighbours are the same, the first stands for both.
    all.dedup_by_key(|(corner, _)| *corner);
    while all.len() > 1 && all.first().map(|one| one.0) == all.last().map(|one| one.0) {
        all.pop();
    }
    all
}

/// The way of the arm's far end, from outside the middle of the last side in, around, and out again; and the sides it goes
/// along, for a contact that is `ratio` times as stiff as the arm.
fn path(outline: &[(Vector, &str)], below_m: f64, ratio: f64) -> (Path, Vec<SideResult>) {
    let count = outline.len();
    let corner = |at: usize| outline[at % count].0;
    let area: f64 = (0..count).map(|at| corner(at)[0] * corner(at + 1)[1] - corner(at)[1] * corner(at + 1)[0]).sum();
    // The outward normal of the side that begins at a corner.
    let normal = |at: usize| {
        let edge = minus(corner(at + 1), corner(at));
        [edge[1], -edge[0]].map(|part| part * area.signum() / size(edge))
    };
    let inset = |at: usize| {
        let (one, other) = (normal(at + count - 1), normal(at));
        add(corner(at), -below_m / (1.0 + dot(one, other)), add(one, 1.0, other))
    };
    let beside = |distance: f64| {
        let middle = add(corner(count - 1), 0.5, minus(corner(count), corner(count - 1)));
        add(middle, distance, normal(count - 1))
    };
    let round = outline.iter().all(|(_, name)| name.is_empty());
    let part = |at: usize| {
        let ([a, b], [c, d]) = (normal(at + count - 1), normal(at));
        let turned = ((a * d - b * c) * area.signum()).atan2(a * c + b * d);
        let cosine = -turned.cos();
        SideResult {
            side: format!("{}-{}", outline[at].1, outline[(at + 1) % count].1),
            corner_deg: Some(180.0 - turned.to_degrees()),
            leaves_at_m: (turned > 0.0 && ratio * cosine < 1.0).then(|| below_m / (1.0 - ratio * cosine)),
            ..SideResult::default()
        }
    };
    let parts = if round {
        vec![SideResult { side: "rim".to_owned(), ..SideResult::default() }]
    } else {
        (0..count).map(part).collect()
    };
    let last = parts.len() - 1;
    let points = [beside(below_m), beside(-below_m)].into_iter().chain((0..count).map(inset));
    let points = points.chain([beside(-below_m), beside(below_m)]).collect();
    let along = std::iter::once(last).chain((0..count).map(|at| at.min(last))).map(Some);
    (Path { points, parts: std::iter::once(None).chain(along).chain([None]).collect() }, parts)
}

/// Strokes along an object.
///
/// # Errors
/// A shape or options that cannot be stroked.
pub fn stroke(shape: &Shape, options: &Options) -> Result<Stroke, Error> {
    let Ok(solid) = solid(shape) else {
        return Err("a strip has no outline to stroke along: choose a wall, a body or a block".into());
    };
    let outline = outline(shape);
    let Options { mass_kg, drag_n_s_per_m, below_m, speed_m_per_s, period_s } = *options;
    let (stiffness, damping) = gains(shape);
    let (path, mut parts) = path(&outline, below_m, stiffness / ARM.0);
    // Every corner of the line lies as deep as the line, or behind a corner that points inwards, deeper.
    let fits = |point: &Vector| solid.depth(*point).is_some_and(|found| found.depth > 0.99 * below_m);
    if !path.points[1..path.points.len() - 1].iter().all(fits) {
        return Err(Error::Refused(format!(
            "below_m = {below_m} is too much for this object: there is no way around it that far under its surface"
        )));
    }
    let law = |mass_kg: f64, damping: f64| {
        let mut settings = Settings::default();
        settings.timing.control_period_s = period_s;
        (settings.object.mass_kg, settings.object.damping_n_s_per_m) = (mass_kg, damping);
        settings.object.force_delay_ticks = 0.0;
        SemiImplicit::<f64>::build(&settings).expect("any mass")
    };
    let (hand_law, object_law) = (law(HAND.0, HAND.1), law(mass_kg, drag_n_s_per_m));
    let contact = contact(shape);
    let mut hand = path.points[0].map(Motion::at);
    let mut object = [Motion::<f64>::REST; 2];
    let mut before = [[Before::default(); 2]; 2];
    let mut energy = Energy::default();
    let mut table = Columns::named(COLUMNS);
    let places = |motions: [Motion<f64>; 2]| motions.map(|axis| axis.position);
    let speeds = |motions: [Motion<f64>; 2]| motions.map(|axis| axis.velocity);
    let ticks = (path.length() / (speed_m_per_s * period_s)).ceil() as usize;
    for tick in 0..ticks {
        let travel_m = speed_m_per_s * period_s * tick as f64;
        let (point, velocity, part) = path.at(travel_m, speed_m_per_s);
        let stretch = minus(add(places(object), 1.0, point), places(hand));
        let gone = minus(add(speeds(object), 1.0, velocity), speeds(hand));
        let arm = add(stretch.map(|part| ARM.0 * part), ARM.1, gone);
        let pressed = solid.press(&contact, hand, object);
        let felt = pressed.force.map(|part| -part);
        let ([hand_x, hand_y], [x, y]) = (minus(places(hand), places(object)), places(object));
        table.push_row(&[travel_m, hand_x, hand_y, felt[0], felt[1], pressed.depth, x, y]);
        if let Some(part) = part.and_then(|at| parts.get_mut(at)) {
            part.largest_depth_m = part.largest_depth_m.max(pressed.depth);
            part.largest_force_n = part.largest_force_n.max(size(felt));
            part.last_force_n = size(felt);
        }
        let last = (hand, object);
        for axis in 0..2 {
            hand[axis] = hand_law.step(&mut before[0][axis], hand[axis], arm[axis] + felt[axis]);
            object[axis] = object_law.step(&mut before[1][axis], object[axis], pressed.force[axis]);
        }
        let next = path.at(travel_m + speed_m_per_s * period_s, speed_m_per_s).0;
        let moved = minus(add(places(object), 1.0, next), add(places(last.1), 1.0, point));
        let between = |old: [Motion<f64>; 2], new| dot(speeds(old), add(speeds(old), 1.0, speeds(new))) / 2.0;
        energy.work_j += dot(arm, moved);
        energy.contact_j += damping * pressed.rate * pressed.rate * period_s;
        energy.drag_j += drag_n_s_per_m * between(last.1, object) * period_s;
        energy.arm_j += (ARM.1 * dot(gone, gone) + HAND.1 * between(last.0, hand)) * period_s;
        energy.stored_j = 0.5 * (stiffness * pressed.depth * pressed.depth + ARM.0 * dot(stretch, stretch));
        let square = |motions: [Motion<f64>; 2]| dot(speeds(motions), speeds(motions));
        energy.moving_j = 0.5 * (HAND.0 * square(hand) + mass_kg * square(object));
    }
    let mut outline: Vec<Vector> = outline.into_iter().map(|(corner, _)| corner).collect();
    outline.extend(outline.first().copied());
    Ok(Stroke { outline, parts, energy, table })
}
