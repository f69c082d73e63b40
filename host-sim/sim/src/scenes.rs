//! The scenes of the folder `scenes/`, built in, so that the papers' experiments run from anywhere.

use std::path::Path;

use crate::Error;
use crate::peers::Laws;
use crate::scene::{Scene, nearest};

macro_rules! scenes {
    ($($name:literal),+ $(,)?) => {
        &[$(($name, include_str!(concat!("../scenes/", $name, ".toml")))),+]
    };
}

/// Name and TOML text of the built-in scenes of two peers that tables of scenes list.
pub const ALL: &[(&str, &str)] = scenes![
    "paper-5.1-power-16ms",
    "paper-5.1-wave-16ms",
    "paper-5.1-passive-wave-16ms",
    "paper-5.1-power-32ms",
    "paper-5.1-wave-32ms",
    "paper-5.1-passive-wave-32ms",
    "paper-5.2-power-16ms",
    "paper-5.2-wave-16ms",
    "paper-5.2-passive-wave-16ms",
    "matched-line",
    "person-reach",
    "real-device",
];

/// Name and text of the others, which only their name finds.
const OTHERS: &[(&str, &str)] = scenes![
    "impulsive",
    "any-network",
    "board-device",
    "four-channel-near",
    "hub",
    "leader-follower",
    "leader-follower-wall",
    "plane",
    "space"
];

/// Every built-in scene, as its name and its text.
pub fn known() -> impl Iterator<Item = &'static (&'static str, &'static str)> {
    ALL.iter().chain(OTHERS)
}

/// TOML text of the built-in scene called `name`, if there is one.
pub fn text(name: &str) -> Option<&'static str> {
    known().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// The built-in scene called `name`.
///
/// # Errors
/// No scene has this name.
pub fn load(laws: Laws, name: &str) -> Result<Scene, Error> {
    Scene::of_text(laws, text(name).ok_or_else(|| unknown(name))?, name, None, &[])
}

/// Name of the built-in scene that `scene` means; none if it is the path of a file, or not given.
///
/// # Errors
/// A bare word that names neither a file nor a built-in scene.
pub fn meant(scene: Option<&Path>) -> Result<Option<&str>, Error> {
    let word = scene.filter(|path| !path.exists()).and_then(Path::to_str).filter(|word| !word.contains(['/', '\\']));
    word.map(|word| text(word).map(|_| word).ok_or_else(|| unknown(word))).transpose()
}

/// The scene of this name or in this file, or the default scene, with the overrides applied in order, then checked.
///
/// # Errors
/// No scene or file has this name, or it cannot be loaded.
pub fn find(laws: Laws, scene: Option<&Path>, overrides: &[String]) -> Result<Scene, Error> {
    match meant(scene)? {
        Some(name) => Scene::of_text(laws, text(name).unwrap_or_default(), name, None, overrides),
        None => Scene::load(laws, scene, overrides),
    }
}

pub(crate) fn unknown(word: &str) -> Error {
    let names = || known().map(|(name, _)| *name);
    let hint = match nearest(word, names()) {
        Some(name) => format!("did you mean {name}?"),
        None => format!("the built-in ones are {}", names().collect::<Vec<_>>().join(", ")),
    };
    format!("{word} is neither a file nor a built-in scene; {hint}").into()
}
