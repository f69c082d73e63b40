//! What can be named: `--keys` of a scene, `--scenes`.

use cohold_sim::{scene::Scene, scenes};
use serde_json::{Value, json};

use super::listing::{Item, list};
use super::{Failure, Ui};

/// A key as a document.
pub fn key(name: String, default: impl Into<Value>, unit: &str, allowed: &str, meaning: &str) -> Value {
    json!({ "key": name, "default": default.into(), "unit": unit, "allowed": allowed, "meaning": meaning })
}

pub(super) fn scene_keys(ui: &Ui) -> Result<(), Failure> {
    let defaults = Scene::new(ui.laws);
    let default = |name: &str| defaults.get(name).map_or_else(String::new, |value| value.to_string());
    let number = |(name, about): (String, cohold_core::settings::Key)| {
        let default = default(&name);
        key(name, default, about.unit, &about.allowed.to_string(), about.doc)
    };
    let file = |name: &str, columns: &str, meaning| {
        key(name.to_owned(), "", "", &format!("name of a CSV file with columns {columns}"), meaning)
    };
    let force = ["user.1.trace", "user.2.trace"];
    let force = force.map(|name| file(name, "time_s,force_n", "Recorded force, added to the others."));
    let meaning = "Recorded network, instead of what its table would draw.";
    let network = file("network.trace", "direction,packet,delay_s,fate", meaning);
    let keys: Vec<Value> = defaults.keys().into_iter().map(number).chain(force).chain([network]).collect();
    say_keys(ui, &keys)
}

/// Keys as one document, or for people: name, default and unit in a line, and what is allowed and meant below.
pub fn say_keys(ui: &Ui, keys: &[Value]) -> Result<(), Failure> {
    ui.document(&keys)?;
    let text = |key: &Value, field: &str| key[field].as_str().map_or_else(|| key[field].to_string(), str::to_owned);
    let item = |key: &Value| {
        let [name, default, unit] = ["key", "default", "unit"].map(|field| text(key, field));
        let head = format!("{name} = {} {unit}", if default.is_empty() { "\"\"" } else { &default });
        Item { head: head.trim_end().to_owned(), body: vec![text(key, "meaning"), text(key, "allowed")] }
    };
    list(ui, &keys.iter().map(item).collect::<Vec<_>>());
    Ok(())
}

/// The built-in scenes, each by the first sentence of its file.
pub(super) fn scenes(ui: &Ui) -> Result<(), Failure> {
    let scene = |(name, text): &(&str, &str)| {
        let lines = text.lines().map_while(|line| line.strip_prefix("# ")).collect::<Vec<_>>().join(" ");
        let about = lines.split_once(". ").map_or(lines.clone(), |(first, _)| format!("{first}."));
        json!({ "name": name, "about": about })
    };
    let scenes: Vec<Value> = scenes::known().map(scene).collect();
    ui.document(&scenes)?;
    let text = |scene: &Value, field: &str| scene[field].as_str().unwrap_or_default().to_owned();
    let item = |scene: &Value| Item { head: text(scene, "name"), body: vec![text(scene, "about")] };
    list(ui, &scenes.iter().map(item).collect::<Vec<_>>());
    Ok(())
}
