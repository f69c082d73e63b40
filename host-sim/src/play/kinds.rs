//! The environments that a page can show by itself: what each is called, what is in its samples, and how it is opened.

use haptic_core::names::Choice;
use haptic_sim::scene::Scene;
use serde_json::{Value, json};

use super::environment::{Column, Environment};
use super::hub::{self, Hub};
use super::partner::Model;
use super::session::{self, Session};
use super::shared_environment::SharedEnvironment;
use super::squash::{self, Squash};
use super::turns::{self, Turns};
use super::visit::{self, Visit};
use crate::Error;

/// An environment that needs nothing but a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum EnvironmentKind {
    /// Two peers hold one object.
    #[default]
    Pair,
    /// Four peers hold one object through a hub.
    Hub,
    /// Squash, the paper's game.
    Squash,
    /// A static world, felt by pushing along it.
    World,
    /// One object, taken in turns by a lock.
    Lock,
    /// One object, taken in turns by a token that goes round.
    Ring,
}

impl Choice for EnvironmentKind {
    const NAMES: &'static [&'static str] = &["pair", "hub", "squash", "world", "lock", "ring"];
    const ALL: &'static [Self] = &[Self::Pair, Self::Hub, Self::Squash, Self::World, Self::Lock, Self::Ring];
}

impl EnvironmentKind {
    /// Index of this kind in the list.
    pub(super) fn number(self) -> u8 {
        Self::ALL.iter().position(|kind| *kind == self).unwrap_or_default() as u8
    }

    /// Its environment in this scene.
    pub(super) fn open(self, scene: &Scene) -> Result<Box<dyn Environment>, Error> {
        Ok(match self {
            Self::Pair => Box::new(Session::new(scene.clone(), Model::default())?),
            Self::Hub => Box::new(SharedEnvironment::<Hub>::new(scene)?),
            Self::Squash => Box::new(SharedEnvironment::<Squash>::new(scene)?),
            Self::World => Box::new(SharedEnvironment::<Visit>::new(scene)?),
            Self::Lock => Box::new(SharedEnvironment::<Turns<true>>::new(scene)?),
            Self::Ring => Box::new(SharedEnvironment::<Turns<false>>::new(scene)?),
        })
    }

    /// What is in its samples.
    pub(super) fn columns(self) -> &'static [Column] {
        match self {
            Self::Pair => &session::COLUMNS,
            Self::Hub => &hub::COLUMNS,
            Self::Squash => &squash::COLUMNS,
            Self::World => &visit::COLUMNS,
            Self::Lock | Self::Ring => &turns::COLUMNS,
        }
    }

    /// What a page gets about all of them.
    pub(super) fn hello() -> Vec<Value> {
        let column = |(name, unit, means): &Column| json!({ "name": name, "unit": unit, "means": means });
        let kind = |(kind, name): (&Self, &&str)| {
            let columns: Vec<_> = kind.columns().iter().map(column).collect();
            let more = match kind {
                Self::Squash => json!({ "size_m": squash::size(), "pointer": squash::POINTER }),
                Self::World => visit::outlines(),
                _ => Value::Null,
            };
            json!({ "name": name, "columns": columns, "more": more })
        };
        Self::ALL.iter().zip(Self::NAMES).map(kind).collect()
    }
}

#[cfg(test)]
#[path = "../../tests/inside/kinds.rs"]
mod tests;
