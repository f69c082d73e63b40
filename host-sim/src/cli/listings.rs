//! What can be named: `--keys` of a scene or a world, `--scenes`.

use haptic_core::settings::Value;
use haptic_protocol::world::{Field, Shape};
use haptic_sim::report::text::TextTable;
use haptic_sim::scene::Scene;
use haptic_sim::scenes;
use serde::Serialize;
use serde_json::json;

use super::{Failure, Ui};
use crate::shared::world;

#[derive(Serialize)]
struct Row {
    key: String,
    default: serde_json::Value,
    unit: &'static str,
    allowed: String,
    meaning: &'static str,
}

fn print(ui: &Ui, rows: &[Row]) -> Result<(), Failure> {
    let mut table = TextTable::new(["key", "default", "unit", "allowed", "meaning"]);
    for Row { key, default, unit, allowed, meaning } in rows {
        let default = default.as_str().map_or_else(|| default.to_string(), str::to_owned);
        table.push([key, &default, *unit, allowed, *meaning]);
    }
    ui.table(&table);
    ui.document(&rows)
}

/// Every key of a scene.
pub(super) fn scene_keys(ui: &Ui) -> Result<(), Failure> {
    let defaults = Scene::default();
    let file = |key: String, columns: &str, meaning| Row {
        key,
        default: json!(""),
        unit: "",
        allowed: format!("name of a CSV file with columns {columns}"),
        meaning,
    };
    let users = (1..=2).map(|user| format!("user.{user}.trace"));
    let rows: Vec<Row> = Scene::keys()
        .into_iter()
        .map(|(key, about)| Row {
            default: json!(defaults.get(&key).as_ref().map(Value::to_string).unwrap_or_default()),
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
    let own = world::OWN_KEYS.iter().map(|(table, field)| (*table, field));
    let shapes = Shape::ALL.iter().flat_map(|(name, _, fields)| fields.iter().map(move |field| (*name, field)));
    let row = |(table, field): (&str, &Field)| Row {
        key: if table.is_empty() { field.name.to_owned() } else { format!("{table}.{}", field.name) },
        default: json!(field.default),
        unit: field.unit,
        allowed: format!("{} {} to {}", if field.whole { "whole," } else { "number," }, field.min, field.max),
        meaning: field.doc,
    };
    print(ui, &own.chain(shapes).map(row).collect::<Vec<_>>())
}

#[derive(Serialize)]
struct BuiltIn {
    name: &'static str,
    about: String,
}

/// The built-in scenes, each by the first sentence of its file.
pub(super) fn scenes(ui: &Ui) -> Result<(), Failure> {
    let about = |text: &str| {
        let lines = text.lines().map_while(|line| line.strip_prefix("# ")).collect::<Vec<_>>().join(" ");
        lines.split_once(". ").map_or(lines.clone(), |(first, _)| format!("{first}."))
    };
    let rows: Vec<BuiltIn> = scenes::known().map(|(name, text)| BuiltIn { name, about: about(text) }).collect();
    let mut table = TextTable::new(["scene", ""]);
    for BuiltIn { name, about } in &rows {
        table.push([*name, about]);
    }
    ui.table(&table);
    ui.document(&rows)
}
