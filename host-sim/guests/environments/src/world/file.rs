//! World file: TOML to database, every key checked.

use std::{collections::BTreeMap, fmt::Display, path::Path};

use cohold_io::Most;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::parameters::{CONTROL_PERIOD_S, World};
use crate::Error;
use crate::records::{Block, Bounds, Field, Object, Region, Shape, Strip};

/// The longest file of a world.
const MOST: Most = Most::new(1 << 24, "a world");

/// The world in the file at `path`; what is wrong is said in one line.
///
/// # Errors
/// The file cannot be read, or the first thing that is wrong in it.
pub fn load(path: &Path) -> Result<Box<World>, Error> {
    let place = path.display().to_string();
    let text = cohold_io::text(path, MOST).map_err(cohold_sim::Error::cannot("read", &place))?;
    parse(&text, &place)
}

const fn field(name: &'static str, range: (f32, f32, bool), unit: &'static str, doc: &'static str) -> Field {
    let (min, max, whole) = range;
    Field { name, default: 0.0, min, max, whole, unit, doc }
}

/// Numbers that are kept exactly.
const COUNT: (f32, f32, bool) = (0.0, 16_777_215.0, true);
const PLACE: (f32, f32, bool) = (-1000.0, 1000.0, false);

const WORLD: [Field; 2] = [
    field("version", COUNT, "", "Version of the world, for people."),
    field("margin_m", (0.0, 1000.0, false), "m", "How far beyond its region a server knows."),
];
const REGION: [Field; 5] = [
    field("server", (1.0, 254.0, true), "", "Number of the server that holds it; no default."),
    field("from_x_m", PLACE, "m", "Least x; no default."),
    field("from_y_m", PLACE, "m", "Least y; no default."),
    field("to_x_m", PLACE, "m", "Largest x; no default."),
    field("to_y_m", PLACE, "m", "Largest y; no default."),
];
const OBJECT: [Field; 2] = [
    field("id", COUNT, "", "Of this object alone; there is no default."),
    field("version", COUNT, "", "Raise it when the object changes: of two, the higher is felt."),
];

/// Every key that is not a shape's, with the table that it stands in.
pub fn own_keys() -> impl Iterator<Item = (&'static str, &'static Field)> {
    let tables: [(&str, &[Field]); 3] = [("", &WORLD), ("region", &REGION), ("wall, body, strip, block", &OBJECT)];
    tables.into_iter().flat_map(|(table, keys)| keys.iter().map(move |key| (table, key)))
}

/// Where something stands, and its text.
struct Source<'a> {
    text: &'a str,
    place: &'a str,
}

impl Source<'_> {
    fn wrong(&self, at: usize, message: impl Display) -> Error {
        let line = self.text[..at.min(self.text.len())].matches('\n').count() + 1;
        cohold_sim::Error::at(format_args!("{}:{line}", self.place), message.to_string()).into()
    }

    /// The number that `key` has in `table`, or its default; what is wrong names `what` it is a key of.
    fn number(&self, table: &DeTable<'_>, what: &str, key: &Field) -> Result<f32, Error> {
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
            let why = format!("{what}: {} = {written} is not allowed: it must be {key}", key.name);
            self.wrong(value.span().start, why)
        })
    }

    /// Every key in `table` is one of `known`.
    fn known(&self, table: &DeTable<'_>, what: &str, known: &[&str]) -> Result<(), Error> {
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
    fn list<'t, 'i>(&self, root: &'t DeTable<'i>, name: &str) -> Result<Vec<(usize, &'t DeTable<'i>)>, Error> {
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

    fn whole(&self, table: &DeTable<'_>, what: &str, key: &Field) -> Result<u32, Error> {
        self.number(table, what, key).map(|number| number as u32)
    }
}

/// The world in `text`, found at `place`.
///
/// # Errors
/// The first thing that is wrong in the text.
pub fn parse(text: &str, place: &str) -> Result<Box<World>, Error> {
    let source = Source { text, place };
    let root = DeTable::parse(text)
        .map_err(|error| source.wrong(error.span().map_or(0, |span| span.start), error.message().replace('\n', " ")))?;
    let root = root.get_ref();
    let mut known = vec!["version", "margin_m", "region"];
    known.extend(Shape::ALL.iter().map(|(name, ..)| *name));
    source.known(root, "a world", &known)?;
    let mut world = Box::<World>::default();
    world.version = source.whole(root, "world", &WORLD[0])?;
    world.margin_m = source.number(root, "world", &WORLD[1])?;
    regions(&source, root, &mut world)?;
    objects(&source, root, &mut world)?;
    Ok(world)
}

fn regions(source: &Source<'_>, root: &DeTable<'_>, world: &mut World) -> Result<(), Error> {
    let keys = REGION.each_ref().map(|key| key.name);
    for (id, (at, table)) in source.list(root, "region")?.into_iter().enumerate() {
        let what = format!("region {}", id + 1);
        source.known(table, &what, &keys)?;
        for key in &keys {
            if !table.iter().any(|(name, _)| *name.get_ref() == *key) {
                return Err(source.wrong(at, format!("{what}: {key} is missing")));
            }
        }
        let mut numbers = [0.0; REGION.len()];
        for (number, key) in numbers.iter_mut().zip(&REGION) {
            *number = source.number(table, &what, key)?;
        }
        let [server, x, y, to_x, to_y] = numbers;
        if x >= to_x || y >= to_y {
            let message = format!("{what}: from_x_m and from_y_m must be below to_x_m and to_y_m");
            return Err(source.wrong(at, message));
        }
        let region = Region { id: id as u8, server: server as u8, bounds: Bounds { min: [x, y], max: [to_x, to_y] } };
        // Regions may touch and not overlap: a point is in one of them.
        let inside = |other: &&Region| {
            let (a, b) = (region.bounds, other.bounds);
            a.min.iter().zip(b.max).all(|(min, max)| *min < max) && b.min.iter().zip(a.max).all(|(min, max)| *min < max)
        };
        if let Some(other) = world.regions().iter().find(inside) {
            return Err(source.wrong(at, format!("{what} overlaps region {}: a place has one server", other.id + 1)));
        }
        world.put_region(region).map_err(|full| source.wrong(at, full))?;
    }
    Ok(())
}

fn objects(source: &Source<'_>, root: &DeTable<'_>, world: &mut World) -> Result<(), Error> {
    let mut lines = BTreeMap::new();
    for (name, kind, fields) in Shape::ALL {
        let keys: Vec<&str> = OBJECT.iter().chain(*fields).map(|key| key.name).collect();
        for (at, table) in source.list(root, name)? {
            if !table.iter().any(|(key, _)| *key.get_ref() == OBJECT[0].name) {
                return Err(source.wrong(at, format!("{name}: id is missing")));
            }
            let id = source.whole(table, name, &OBJECT[0])?;
            let what = format!("{name} {id}");
            source.known(table, &what, &keys)?;
            let version = source.whole(table, &what, &OBJECT[1])?;
            let mut numbers = [0.0; Shape::NUMBERS];
            for (number, key) in numbers.iter_mut().zip(*fields) {
                *number = source.number(table, &what, key)?;
            }
            let shape = match Shape::build(*kind, &numbers) {
                Some(Ok(shape)) => shape,
                Some(Err(refused)) => return Err(source.wrong(at, refused)),
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
            world.put(Object { id, version, shape }).map_err(|full| source.wrong(at, full))?;
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
