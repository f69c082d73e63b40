//! World file: TOML to database, every key checked.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use haptic_protocol::world::{Block, Bounds, Field, Object, Region, Shape, Strip};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::parameters::{CONTROL_PERIOD_S, World};

/// What is wrong with a world, in one line.
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// The file cannot be read.
    #[error("cannot read {path}: {cause}")]
    Read {
        /// Which file.
        path: PathBuf,
        /// Why not.
        cause: std::io::Error,
    },
    /// Something in it is wrong.
    #[error("{place}:{line}: {message}")]
    Wrong {
        /// Which file.
        place: String,
        /// Which line.
        line: usize,
        /// What, and what is allowed.
        message: String,
    },
}

/// The world in the file at `path`.
pub fn load(path: &Path) -> Result<Box<World>, WorldError> {
    let text = std::fs::read_to_string(path).map_err(|cause| WorldError::Read { path: path.to_path_buf(), cause })?;
    parse(&text, &path.display().to_string())
}

const fn field(name: &'static str, range: (f32, f32, bool), unit: &'static str, doc: &'static str) -> Field {
    let (min, max, whole) = range;
    Field { name, default: 0.0, min, max, whole, unit, doc }
}

/// Numbers that are kept exactly.
const COUNT: (f32, f32, bool) = (0.0, 16_777_215.0, true);
const PLACE: (f32, f32, bool) = (-1000.0, 1000.0, false);

const WORLD_VERSION: Field = field("version", COUNT, "", "Version of the world, for people.");
const MARGIN: Field = field("margin_m", (0.0, 1000.0, false), "m", "How far beyond its region a server knows.");
const ID: Field = field("id", COUNT, "", "Of this object alone; there is no default.");
const VERSION: Field = field("version", COUNT, "", "Raise it when the object changes: of two, the higher is felt.");
const SERVER: Field = field("server", (1.0, 254.0, true), "", "Number of the server that holds it; no default.");
const FROM_X: Field = field("from_x_m", PLACE, "m", "Least x; no default.");
const FROM_Y: Field = field("from_y_m", PLACE, "m", "Least y; no default.");
const TO_X: Field = field("to_x_m", PLACE, "m", "Largest x; no default.");
const TO_Y: Field = field("to_y_m", PLACE, "m", "Largest y; no default.");
const REGION: [Field; 4] = [FROM_X, FROM_Y, TO_X, TO_Y];

/// Every key that is not a shape's, with the table that it stands in.
pub const OWN_KEYS: &[(&str, Field)] = &[
    ("", WORLD_VERSION),
    ("", MARGIN),
    ("region", SERVER),
    ("region", FROM_X),
    ("region", FROM_Y),
    ("region", TO_X),
    ("region", TO_Y),
    ("wall, body, strip, block", ID),
    ("wall, body, strip, block", VERSION),
];

/// Where something stands, and its text.
struct Source<'a> {
    text: &'a str,
    place: &'a str,
}

impl Source<'_> {
    fn wrong(&self, at: usize, message: impl Into<String>) -> WorldError {
        let line = self.text[..at.min(self.text.len())].matches('\n').count() + 1;
        WorldError::Wrong { place: self.place.to_owned(), line, message: message.into() }
    }

    /// The number that `key` has in `table`, or its default; what is wrong names `what` it is a key of.
    fn number(&self, table: &DeTable<'_>, what: &str, key: &Field) -> Result<f32, WorldError> {
        let Some((_, value)) = table.iter().find(|(name, _)| *name.get_ref() == key.name) else {
            return Ok(key.default);
        };
        let number = match value.get_ref() {
            DeValue::Integer(whole) => whole.to_string().parse::<f64>().ok(),
            DeValue::Float(number) => number.as_str().parse::<f64>().ok(),
            _ => None,
        };
        let written = self.text.get(value.span()).unwrap_or("?");
        let accepted = number.map(|number| number as f32).filter(|number| key.allows(*number));
        accepted.ok_or_else(|| {
            let kind = if key.whole { "a whole number" } else { "a number" };
            let Field { name, min, max, unit, .. } = key;
            let allowed = format!("{what}: {name} = {written} is not allowed: it must be {kind} from {min} to {max}");
            self.wrong(value.span().start, format!("{allowed} {unit}").trim_end())
        })
    }

    /// Every key in `table` is one of `known`.
    fn known(&self, table: &DeTable<'_>, what: &str, known: &[&str]) -> Result<(), WorldError> {
        match table.iter().find(|(name, _)| !known.iter().any(|known| *name.get_ref() == *known)) {
            None => Ok(()),
            Some((name, _)) => {
                let text = name.get_ref();
                let message = format!("there is no key {text} in {what}; the keys are {}", known.join(", "));
                Err(self.wrong(name.span().start, message))
            }
        }
    }

    /// The tables of the list called `name`, with where each stands.
    fn list<'t, 'i>(&self, root: &'t DeTable<'i>, name: &str) -> Result<Vec<(usize, &'t DeTable<'i>)>, WorldError> {
        let Some((_, value)) = root.iter().find(|(key, _)| *key.get_ref() == name) else { return Ok(Vec::new()) };
        let refused = |value: &Spanned<DeValue<'_>>| {
            self.wrong(value.span().start, format!("{name} must be a list of tables: write [[{name}]]"))
        };
        let DeValue::Array(items) = value.get_ref() else { return Err(refused(value)) };
        let tables = items.iter().map(|item| match item.get_ref() {
            DeValue::Table(table) => Ok((item.span().start, table)),
            _ => Err(refused(item)),
        });
        tables.collect()
    }

    fn whole(&self, table: &DeTable<'_>, what: &str, key: &Field) -> Result<u32, WorldError> {
        self.number(table, what, key).map(|number| number as u32)
    }
}

/// The world in `text`, found at `place`.
pub fn parse(text: &str, place: &str) -> Result<Box<World>, WorldError> {
    let source = Source { text, place };
    let root = DeTable::parse(text)
        .map_err(|error| source.wrong(error.span().map_or(0, |span| span.start), error.message().replace('\n', " ")))?;
    let root = root.get_ref();
    let mut known = vec!["version", "margin_m", "region"];
    known.extend(Shape::ALL.iter().map(|(name, ..)| *name));
    source.known(root, "a world", &known)?;
    let mut world = Box::<World>::default();
    world.version = source.whole(root, "world", &WORLD_VERSION)?;
    world.margin_m = source.number(root, "world", &MARGIN)?;
    regions(&source, root, &mut world)?;
    objects(&source, root, &mut world)?;
    Ok(world)
}

fn regions(source: &Source<'_>, root: &DeTable<'_>, world: &mut World) -> Result<(), WorldError> {
    let keys: Vec<&str> = std::iter::once(SERVER.name).chain(REGION.iter().map(|key| key.name)).collect();
    for (id, (at, table)) in source.list(root, "region")?.into_iter().enumerate() {
        let what = format!("region {}", id + 1);
        source.known(table, &what, &keys)?;
        for key in &keys {
            if !table.iter().any(|(name, _)| *name.get_ref() == *key) {
                return Err(source.wrong(at, format!("{what}: {key} is missing")));
            }
        }
        let mut corners = [0.0; 4];
        for (corner, key) in corners.iter_mut().zip(&REGION) {
            *corner = source.number(table, &what, key)?;
        }
        let [x, y, to_x, to_y] = corners;
        if x >= to_x || y >= to_y {
            let message = format!("{what}: from_x_m and from_y_m must be below to_x_m and to_y_m");
            return Err(source.wrong(at, message));
        }
        let server = source.whole(table, &what, &SERVER)? as u8;
        let region = Region { id: id as u8, server, bounds: Bounds { min: [x, y], max: [to_x, to_y] } };
        // Regions may touch and not overlap: a point is in one of them.
        let inside = |other: &&Region| {
            let (a, b) = (region.bounds, other.bounds);
            a.min.iter().zip(b.max).all(|(min, max)| *min < max) && b.min.iter().zip(a.max).all(|(min, max)| *min < max)
        };
        if let Some(other) = world.regions().iter().find(inside) {
            return Err(source.wrong(at, format!("{what} overlaps region {}: a place has one server", other.id + 1)));
        }
        world.put_region(region).map_err(|full| source.wrong(at, full.to_string()))?;
    }
    Ok(())
}

fn objects(source: &Source<'_>, root: &DeTable<'_>, world: &mut World) -> Result<(), WorldError> {
    let mut lines = BTreeMap::new();
    for (name, kind, fields) in Shape::ALL {
        let keys: Vec<&str> = [ID.name, VERSION.name].into_iter().chain(fields.iter().map(|key| key.name)).collect();
        for (at, table) in source.list(root, name)? {
            if !table.iter().any(|(key, _)| *key.get_ref() == ID.name) {
                return Err(source.wrong(at, format!("{name}: id is missing")));
            }
            let id = source.whole(table, name, &ID)?;
            let what = format!("{name} {id}");
            source.known(table, &what, &keys)?;
            let version = source.whole(table, &what, &VERSION)?;
            let mut numbers = [0.0; Shape::NUMBERS];
            for (number, key) in numbers.iter_mut().zip(*fields) {
                *number = source.number(table, &what, key)?;
            }
            let shape = match Shape::build(*kind, &numbers) {
                Some(Ok(shape)) => shape,
                Some(Err(refused)) => return Err(source.wrong(at, refused.to_string())),
                None => return Err(source.wrong(at, format!("{what}: there is no such shape"))),
            };
            if let Some(message) = impossible(&shape) {
                return Err(source.wrong(at, format!("{what}: {message}")));
            }
            if let Some(other) = lines.insert(id, what.clone()) {
                return Err(
                    source.wrong(at, format!("{what}: id = {id} is {other}'s already: every object has its own"))
                );
            }
            world.put(Object { id, version, shape }).map_err(|full| source.wrong(at, full.to_string()))?;
        }
    }
    Ok(())
}

/// What no single range can say.
fn impossible(shape: &Shape) -> Option<String> {
    let point = |from: [f32; 2], to: [f32; 2]| {
        (from == to).then(|| "from and to are the same point: it must have a length".to_owned())
    };
    match shape {
        Shape::Body(_) => None,
        Shape::Wall(wall) => point([wall.from_x_m, wall.from_y_m], [wall.to_x_m, wall.to_y_m]),
        Shape::Strip(strip) => {
            point([strip.from_x_m, strip.from_y_m], [strip.to_x_m, strip.to_y_m]).or_else(|| too_stiff(strip))
        }
        Shape::Block(block) => no_outline(block),
    }
}

/// Sides that cross or lie on each other enclose nothing that has an inside.
fn no_outline(block: &Block) -> Option<String> {
    let [a, b, c, d] = block.corners().map(|corner| corner.map(f64::from));
    // Twice the area on the left of the way from p over q to r.
    let left = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let crossed = |[p, q]: [[f64; 2]; 2], [r, s]: [[f64; 2]; 2]| {
        left(p, q, r) * left(p, q, s) < 0.0 && left(r, s, p) * left(r, s, q) < 0.0
    };
    let message = if crossed([a, b], [c, d]) || crossed([b, c], [d, a]) {
        "its sides cross: name the corners a, b, c, d in order around it"
    } else if left(a, b, c) + left(a, c, d) == 0.0 {
        "its sides enclose nothing: it must have an area"
    } else {
        return None;
    };
    Some(message.to_owned())
}

/// Semi-implicit Euler of m·ü = −k·u − b·u̇ is stable for k·T²/m + 2·b·T/m < 4. The stiffest mode of a chain has four times its
/// spring, and the hand may hold it against the contact.
fn too_stiff(strip: &Strip) -> Option<String> {
    let Strip { mass_kg, spring_n_per_m, drag_n_s_per_m, stiffness_n_per_m, damping_n_s_per_m, .. } = *strip;
    let stiffness = 4.0 * f64::from(spring_n_per_m) + f64::from(stiffness_n_per_m);
    let damping = f64::from(drag_n_s_per_m) + f64::from(damping_n_s_per_m);
    let needed = 0.25 * CONTROL_PERIOD_S * (stiffness * CONTROL_PERIOD_S + 2.0 * damping);
    (f64::from(mass_kg) <= needed).then(|| {
        format!("mass_kg = {mass_kg} is not allowed: with these springs and dampers it must be above {needed:.3e} kg")
    })
}
