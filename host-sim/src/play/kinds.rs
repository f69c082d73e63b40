//! The environments that a page can show by itself: what each is called, what is in its samples, and how it is opened.

use cohold_core::names::Choice;
use cohold_core::settings::Refused;
use cohold_sim::peers::Builds;
use cohold_sim::{of_axes, scene::Scene};
use serde_json::{Value, json};

use super::environment::{Column, Environment};
use super::hub::{self, Hub};
use super::pair_columns;
use super::partner::Model;
use super::session::Session;
use super::shared_environment::SharedEnvironment;
use super::squash::{self, Squash};
use super::story::{self, Story};
use super::three_laws::{self, ThreeLaws};
use super::turns::{self, Turns};
use super::visit::{self, Visit};
use cohold_cli::Failure;

cohold_sim::choices! {
    /// An environment that needs nothing but a scene.
    EnvironmentKind {
        "pair" => Pair, "Two peers hold one object along one axis.";
        "hub" => Hub, "Four peers hold one object through a hub.";
        "squash" => Squash, "Squash, the paper's game.";
        "world" => World, "A static world, felt by pushing along it.";
        "lock" => Lock, "One object, taken in turns by a lock.";
        "ring" => Ring, "One object, taken in turns by a token that goes round.";
        "plane" => Plane, "Two peers hold one object in the plane.";
        "space" => Space, "Two peers hold one object in space.";
        "bad-network" => BadNetwork, "Three laws side by side, on one bad network.";
        "delay" => Delay, "Two hands pull an object apart, later and later.";
        "too-stiff" => TooStiff, "Two hands on an object whose coupling is too stiff.";
    }
}

impl Default for EnvironmentKind {
    /// The first of the table.
    fn default() -> Self {
        Self::ALL[0]
    }
}

impl EnvironmentKind {
    /// Index of this kind in the list.
    pub(super) fn number(self) -> u8 {
        Self::ALL.iter().position(|kind| *kind == self).unwrap_or_default() as u8
    }

    /// Whether this is a picture with a scene of its own, which leaves that of the workshop as it was.
    pub(crate) fn is_story(self) -> bool {
        matches!(self, Self::BadNetwork | Self::Delay | Self::TooStiff)
    }

    /// Along how many axes the two peers of this kind share their object; of others none.
    pub(super) fn axes(self) -> Option<u32> {
        match self {
            Self::Pair => Some(1),
            Self::Plane => Some(2),
            Self::Space => Some(3),
            _ => None,
        }
    }

    /// What shows this scene where this kind was shown: two peers share their object along as many axes as it says.
    pub(crate) fn in_scene(self, scene: &Scene) -> Self {
        match (self.axes(), scene.peer.axis.shared) {
            (None, _) => self,
            (_, 1) => Self::Pair,
            (_, 2) => Self::Plane,
            (_, _) => Self::Space,
        }
    }

    /// The scene as this kind shows it.
    ///
    /// # Errors
    /// The scene cannot be shared along so many axes.
    pub(crate) fn fitting(self, scene: Scene) -> Result<Scene, Failure> {
        let mut scene = match self {
            Self::BadNetwork => three_laws::lossy(scene),
            Self::Delay => story::scene(scene.laws, &story::DELAY)?,
            Self::TooStiff => story::scene(scene.laws, &story::TOO_STIFF)?,
            _ => scene,
        };
        // Four hands at a hub and three laws hold one axis, as a pair does that nobody says more of.
        let axes = self.axes().or((self == Self::Hub || self.is_story()).then_some(1));
        if let Some(axes) = axes.filter(|axes| *axes != scene.peer.axis.shared) {
            (scene.peer.axis.count, scene.peer.axis.shared) = (axes, axes);
            scene.check("this environment")?;
        }
        Ok(scene)
    }

    /// Its environment in this scene.
    pub(super) fn open(self, scene: &Scene) -> Result<Box<dyn Environment>, Failure> {
        Ok(match self {
            Self::Pair | Self::Plane | Self::Space => of_axes!(scene, pair(scene))?,
            Self::Hub => Box::new(SharedEnvironment::<Hub>::new(scene)?),
            Self::Squash => Box::new(SharedEnvironment::<Squash>::new(scene)?),
            Self::World => Box::new(SharedEnvironment::<Visit>::new(scene)?),
            Self::Lock => Box::new(SharedEnvironment::<Turns<true>>::new(scene)?),
            Self::Ring => Box::new(SharedEnvironment::<Turns<false>>::new(scene)?),
            Self::BadNetwork => Box::new(ThreeLaws::new(scene)?),
            Self::Delay | Self::TooStiff => Box::new(Story::new(scene)?),
        })
    }

    /// What is in its samples.
    pub(super) fn columns(self) -> &'static [Column] {
        match self {
            Self::Pair | Self::Delay | Self::TooStiff => pair_columns::columns(1),
            Self::Plane => pair_columns::columns(2),
            Self::Space => pair_columns::columns(3),
            Self::Hub => &hub::COLUMNS,
            Self::Squash => &squash::COLUMNS,
            Self::World => &visit::COLUMNS,
            Self::Lock | Self::Ring => &turns::COLUMNS,
            Self::BadNetwork => &three_laws::COLUMNS,
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
            json!({ "name": name, "story": kind.is_story(), "columns": columns, "more": more })
        };
        Self::ALL.iter().zip(Self::NAMES).map(kind).collect()
    }
}

/// Two peers, along as many axes as the scene says.
fn pair<const SHARED: usize, const N: usize>(scene: &Scene) -> Result<Box<dyn Environment>, Refused<'static>>
where
    f32: Builds<SHARED, N>,
{
    Ok(Box::new(Session::<SHARED, N>::new(scene.clone(), Model::default())?))
}

#[cfg(test)]
#[path = "../../tests/inside/kinds.rs"]
mod tests;
