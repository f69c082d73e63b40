//! The settings file that calibrations leave: a scene of a few keys, which `cooperate --scene` and boards take.
//!
//! Each calibration adds its keys to what the file holds; a key that is found again is replaced.

use std::path::Path;

use cohold_core::settings::{Settings, Value};
use cohold_io::Kind;
use cohold_sim::scene::{MOST, Scene};

use super::Found;
use super::board::{Board, say};
use crate::Error;

/// Adds what was found to the file at `path`, which is made if it is not there.
///
/// # Errors
/// The file cannot be read as a scene, or cannot be written.
pub fn add(path: &Path, found: &[Found]) -> Result<(), Error> {
    let place = path.display();
    let before = if path.exists() {
        cohold_io::text(path, MOST).map_err(cohold_sim::Error::cannot("read", &place))?
    } else {
        String::new()
    };
    let mut document: toml::Table = before.parse().map_err(|error| format!("{place}: {error}").replace('\n', " "))?;
    for Found { key, value, .. } in found {
        let (table, name) = key.split_once('.').unwrap_or(("", key));
        let entry = document.entry(table).or_insert_with(|| toml::Value::Table(toml::Table::new()));
        let Some(inner) = entry.as_table_mut() else {
            return Err(cohold_sim::Error::at(place, format!("{table} is no table")).into());
        };
        inner.insert(name.to_owned(), value.clone());
    }
    let text = format!("# Found by `cohold board calibrate`; a scene file, in part.\n\n{document}");
    Scene::default().apply(&text, &place.to_string(), path.parent())?;
    Ok(cohold_io::write(path, text.as_bytes(), Kind::Named).map_err(cohold_sim::Error::cannot("write", &place))?)
}

/// The keys that a scene's text names, as `table.key`; none where it is no TOML.
pub fn named(text: &str) -> Vec<String> {
    let document: toml::Table = text.parse().unwrap_or_default();
    let keys = |(table, inner): (&String, &toml::Value)| -> Vec<String> {
        inner.as_table().into_iter().flat_map(toml::Table::keys).map(|name| format!("{table}.{name}")).collect()
    };
    document.iter().flat_map(keys).collect()
}

/// A value as a board's lines and recordings spell it: numbers exactly, names without quotes.
pub fn plain(value: Value<'_>) -> String {
    match value {
        Value::Number(number) => format!("{number:?}"),
        Value::Flag(flag) => flag.to_string(),
        Value::Text(text) => text.to_owned(),
    }
}

/// Gives a board what of a scene is the board's, keys that the file names only, and has it taken.
///
/// # Errors
/// The file cannot be read, or the board refuses a key.
pub fn give(board: &mut dyn Board, path: &Path) -> Result<usize, Error> {
    let scene = Scene::load(cohold_sim::Laws::built_in(), Some(path), &[])?;
    let text = cohold_io::text(path, MOST).map_err(cohold_sim::Error::cannot("read", &path.display()))?;
    give_scene(board, &scene, &named(&text))
}

/// Gives a board these keys of a scene, as far as they are the board's own, and has them taken. Gives how many.
///
/// # Errors
/// The board refuses a key.
pub fn give_scene(board: &mut dyn Board, scene: &Scene, named: &[String]) -> Result<usize, Error> {
    let mut given = 0;
    for key in Settings::keys().filter(|key| named.iter().any(|name| name == key.name)) {
        let Some(value) = scene.peer.get(key.name) else { continue };
        let line = format!("set {} {}", key.name, plain(value));
        say(board, &line)?;
        given += 1;
    }
    say(board, "apply")?;
    Ok(given)
}
