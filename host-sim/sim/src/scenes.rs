//! The scenes of the folder `scenes/`, built in, so that the papers' experiments run from anywhere.

use crate::peers::Laws;
use crate::scene::{Scene, SceneError};

macro_rules! scenes {
    ($($name:literal),+ $(,)?) => {
        &[$(($name, include_str!(concat!("../../../scenes/", $name, ".toml")))),+]
    };
}

/// Name and text of every scene of the cooperation paper's kind: those that tables go through.
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
pub const OTHERS: &[(&str, &str)] = scenes!["impulsive", "any-network"];

/// Every built-in scene.
pub fn known() -> impl Iterator<Item = &'static (&'static str, &'static str)> {
    ALL.iter().chain(OTHERS)
}

/// The text of the built-in scene called `name`, if there is one.
pub fn text(name: &str) -> Option<&'static str> {
    known().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// The built-in scene called `name`.
pub fn load(laws: Laws, name: &str) -> Result<Scene, SceneError> {
    let text = text(name).ok_or_else(|| SceneError::Unknown {
        place: "built-in scenes".to_owned(),
        key: name.to_owned(),
        hint: format!("; there are {}", known().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")),
    })?;
    let mut scene = Scene::new(laws);
    scene.apply(text, name, None)?;
    scene.check(name)?;
    Ok(scene)
}
