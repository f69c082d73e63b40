//! The environments that a page can show by itself, and how each is opened.

use haptic_core::names::Choice;
use haptic_sim::scene::Scene;

use super::environment::Environment;
use super::partner::Model;
use super::session::Session;

/// An environment that needs nothing but a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Two peers hold one object.
    #[default]
    Pair,
}

impl Choice for Kind {
    const NAMES: &'static [&'static str] = &["pair"];
    const ALL: &'static [Self] = &[Self::Pair];
}

impl Kind {
    /// Its environment in this scene.
    pub(super) fn open(self, scene: &Scene) -> Result<Box<dyn Environment>, String> {
        match self {
            Self::Pair => Ok(Box::new(Session::new(scene.clone(), Model::default()).map_err(|why| why.to_string())?)),
        }
    }
}
