//! What can be named: `--keys` of a scene or a world, `--scenes`.

use haptic_core::settings::Value;
use haptic_protocol::world::{Field, Shape};
use haptic_sim::report::{Cell, Columns};
use haptic_sim::scene::Scene;
use haptic_sim::scenes;

use super::{Failure, Ui};
use crate::shared::world;

struct Row {
    key: String,
    default: Cell,
    unit: &'static str,
    allowed: String,
    meaning: &'static str,
}

fn print(ui: &Ui, rows: &[Row]) -> Result<(), Failure> {
    let keys = Columns::of(rows)
        .value("key", |row| row.key.clone())
        .value("default", |row| row.default.clone())
        .value("unit", |row| row.unit)
        .value("allowed", |row| row.allowed.clone())
        .value("meaning", |row| row.meaning)
        .done();
    ui.table(&keys);
    ui.document(&keys)
}

/// Every key of a scene.
pub(super) fn scene_keys(ui: &Ui) -> Result<(), Failure> {
    let defaults = Scene::new(ui.laws);
    let file = |key: String, columns: &str, meaning| Row {
        key,
        default: "".into(),
        unit: "",
        allowed: format!("name of a CSV file with columns {columns}"),
        meaning,
    };
    let users = (1..=2).map(|user| format!("user.{user}.trace"));
    let rows: Vec<Row> = defaults
        .keys()
        .into_iter()
        .map(|(key, about)| Row {
            default: defaults.get(&key).as_ref().map(Value::to_string).unwrap_or_default().into(),
            key,
            unit: about.unit,
            allowed: about.allowed.to_string(),
            meaning: about.doc,
        })
        .chain(users.map(|key| file(key, "time_s,force_n", "Recorded force, added to the others.")))
        .chain([file(
            "network.trace".to_owned(),
            "direction,packet,delay_s,fate",
            "Recorded network, instead of what its table would draw.",
        )])
        .collect();
    print(ui, &rows)
}

/// Every key of a world file.
pub(super) fn world_keys(ui: &Ui) -> Result<(), Failure> {
    let own = world::own_keys();
    let shapes = Shape::ALL.iter().flat_map(|(name, _, fields)| fields.iter().map(move |field| (*name, field)));
    let row = |(table, field): (&str, &Field)| Row {
        key: if table.is_empty() { field.name.to_owned() } else { format!("{table}.{}", field.name) },
        // As it was declared: 0.1, and not the f32 nearest to it.
        default: field.default.to_string().parse::<f64>().ok().into(),
        unit: field.unit,
        allowed: format!("{} {} to {}", if field.whole { "whole," } else { "number," }, field.min, field.max),
        meaning: field.doc,
    };
    print(ui, &own.chain(shapes).map(row).collect::<Vec<_>>())
}

/// The built-in scenes, each by the first sentence of its file.
pub(super) fn scenes(ui: &Ui) -> Result<(), Failure> {
    let about = |text: &str| {
        let lines = text.lines().map_while(|line| line.strip_prefix("# ")).collect::<Vec<_>>().join(" ");
        lines.split_once(". ").map_or(lines.clone(), |(first, _)| format!("{first}."))
    };
    let known: Vec<_> = scenes::known().collect();
    let scenes = Columns::of(&known).value("name", |(name, _)| *name).value("about", |(_, text)| about(text)).done();
    ui.table(&scenes);
    ui.document(&scenes)
}
