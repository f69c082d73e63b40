//! The scenes of the folder `scenes/`, built in, so that the papers' experiments run from anywhere.

use crate::scene::{SceneError, SceneFile};

macro_rules! scenes {
    ($($name:literal),+ $(,)?) => {
        /// Name and text of every scene.
        pub const ALL: &[(&str, &str)] = &[$(($name, include_str!(concat!("../../scenes/", $name, ".toml")))),+];
    };
}

scenes![
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

/// The built-in scene called `name`.
///
/// # Errors
/// There is none of that name, or its text is wrong.
pub fn load(name: &str) -> Result<SceneFile, SceneError> {
    let (_, text) = ALL.iter().find(|(known, _)| *known == name).ok_or_else(|| SceneError::Unknown {
        place: "built-in scenes".to_owned(),
        key: name.to_owned(),
        hint: format!("; there are {}", ALL.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")),
    })?;
    let mut scene = SceneFile::default();
    scene.apply(text, name, None)?;
    scene.check(name)?;
    Ok(scene)
}
