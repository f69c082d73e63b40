//! The environments that a page can show: their names, the columns of their samples, and how they are opened.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use cohold_core::settings::Refused;
use cohold_live::playable::{Column, Playable};
use cohold_sim::peers::Builds;
use cohold_sim::{of_axes, scene::Scene};
use serde_json::{Value, json};

use super::environment::Environment;
use super::pair_columns;
use super::partner::Model;
use super::session::Session;
use super::shared_environment::SharedEnvironment;
use super::story::{self, Story};
use super::three_laws::{self, ThreeLaws};
use cohold_cli::Failure;

/// An environment that needs nothing but a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum EnvironmentKind {
    /// Two peers hold one object along one axis.
    #[default]
    Pair,
    /// The same in the plane.
    Plane,
    /// The same in space.
    Space,
    /// Three laws side by side, on one bad network.
    BadNetwork,
    /// Two hands pull an object apart, later and later.
    Delay,
    /// Two hands on an object whose coupling is too stiff.
    TooStiff,
    /// Another guest's, with its number among all.
    Shared(&'static Playable, u8),
}

/// The page's own, by name.
const OWN: [(&str, EnvironmentKind); 6] = [
    ("pair", EnvironmentKind::Pair),
    ("plane", EnvironmentKind::Plane),
    ("space", EnvironmentKind::Space),
    ("bad-network", EnvironmentKind::BadNetwork),
    ("delay", EnvironmentKind::Delay),
    ("too-stiff", EnvironmentKind::TooStiff),
];

/// All environments: the page's, and the other guests'.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Kinds(pub(crate) &'static [Playable]);

impl Kinds {
    /// Each of them, in the order of their numbers.
    pub(super) fn all(self) -> impl Iterator<Item = EnvironmentKind> {
        let own = OWN.into_iter().map(|(_, kind)| kind);
        own.chain((OWN.len() as u8..).zip(self.0).map(|(number, of)| EnvironmentKind::Shared(of, number)))
    }

    /// The one of this name.
    pub(super) fn named(self, name: &str) -> Option<EnvironmentKind> {
        self.all().find(|kind| kind.name() == name)
    }

    /// Their names.
    pub(super) fn names(self) -> Vec<&'static str> {
        self.all().map(EnvironmentKind::name).collect()
    }

    /// One of their names, on the command line.
    pub(super) fn parser(self) -> impl TypedValueParser<Value = EnvironmentKind> {
        PossibleValuesParser::new(self.names()).try_map(move |name| self.named(&name).ok_or("there is no such name"))
    }

    /// What a page gets about all of them.
    pub(super) fn hello(self) -> Vec<Value> {
        let column = |(name, unit, means): &Column| json!({ "name": name, "unit": unit, "means": means });
        let kind = |kind: EnvironmentKind| {
            let columns: Vec<_> = kind.columns().iter().map(column).collect();
            let more = if let EnvironmentKind::Shared(of, _) = kind { (of.more)() } else { Value::Null };
            json!({ "name": kind.name(), "story": kind.is_story(), "columns": columns, "more": more })
        };
        self.all().map(kind).collect()
    }
}

impl EnvironmentKind {
    /// Index of this kind in the list.
    pub(super) fn number(self) -> u8 {
        let own = || OWN.iter().position(|(_, kind)| *kind == self).unwrap_or_default() as u8;
        if let Self::Shared(_, number) = self { number } else { own() }
    }

    /// The name by which it is chosen.
    pub(super) fn name(self) -> &'static str {
        let own = || OWN[usize::from(self.number())].0;
        if let Self::Shared(of, _) = self { of.name } else { own() }
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
        // A picture holds one axis, as a pair does of which nobody says more.
        let axes = match self {
            Self::Shared(of, _) => of.axes,
            _ => self.axes().or(self.is_story().then_some(1)),
        };
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
            Self::Shared(of, _) => Box::new(SharedEnvironment::new(of, scene)?),
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
            Self::Shared(of, _) => of.columns,
            Self::BadNetwork => &three_laws::COLUMNS,
        }
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
#[path = "../tests/inside/kinds.rs"]
mod tests;
