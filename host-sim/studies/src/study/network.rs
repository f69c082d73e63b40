//! Networks of a study: those of the campaign and the bench by name, a recording, or each entrant's own.

use std::path::Path;

use haptic_sim::scene::{Scene, nearest};

use crate::Error;
use crate::bench::networks::{Network, TEST, TUNING};
use crate::networks::{IMPAIRMENTS, Named};

/// What each entrant's own network is called.
pub const OWN: &str = "own";
/// All networks that have a name.
pub const ALL: &str = "all";

/// A network that every entrant is run over: what it does not say is as the entrant has it.
#[derive(Clone, Debug)]
pub struct Over {
    /// Its name.
    pub name: String,
    network: Option<Network>,
}

impl From<&Network> for Over {
    fn from(network: &Network) -> Self {
        Self { name: network.name.clone(), network: Some(network.clone()) }
    }
}

/// Those that have a name, each once. One that sets nothing is the entrant's own.
fn named() -> Vec<Named> {
    let mut all: Vec<Named> = Vec::new();
    for network in IMPAIRMENTS.iter().chain(TUNING).chain(TEST) {
        if !network.1.is_empty() && !all.iter().any(|(name, _)| *name == network.0) {
            all.push(*network);
        }
    }
    all
}

impl Over {
    /// The names of networks.
    pub fn names() -> impl Iterator<Item = &'static str> {
        std::iter::once(OWN).chain(named().into_iter().map(|(name, _)| name))
    }

    /// Each entrant's own network.
    pub fn own() -> Self {
        Self { name: OWN.to_owned(), network: None }
    }

    /// Those of a list; one that sets nothing is each entrant's own.
    pub(crate) fn each(list: &[Named]) -> Vec<Self> {
        let of = |network: Network| Self { name: network.name.clone(), network: network.sets().then_some(network) };
        Network::named(list).into_iter().map(of).collect()
    }

    /// The network of this name, strokes for blanks or not, or all of them.
    ///
    /// # Errors
    /// A name that no network has.
    pub fn of(text: &str) -> Result<Vec<Self>, Error> {
        let all = named();
        // In a shell a name is easier to type with strokes for blanks.
        let typed = |name: &str| name.replace(' ', "-");
        match (text, all.iter().find(|(name, _)| typed(name) == typed(text))) {
            (OWN, _) => Ok(vec![Self::own()]),
            (ALL, _) => Ok(std::iter::once(Self::own()).chain(Self::each(&all)).collect()),
            (_, Some(network)) => Ok(Self::each(&[*network])),
            (_, None) => {
                let hint = nearest(text, Self::names()).map(|near| format!("did you mean {near:?}? "));
                let names: Vec<String> = Self::names().chain([ALL]).map(|name| format!("{name:?}")).collect();
                let (hint, names) = (hint.unwrap_or_default(), names.join(", "));
                Err(format!("there is no network called {text:?}; {hint}They are {names}").into())
            }
        }
    }

    /// A recording.
    ///
    /// # Errors
    /// A file that is none.
    pub fn of_trace(file: &Path) -> Result<Self, Error> {
        let network = Network::of_trace(file)?;
        Ok(Self { name: network.name.clone(), network: Some(network) })
    }

    /// The recording, of one that is.
    pub fn trace_file(&self) -> Option<&Path> {
        self.network.as_ref().and_then(Network::trace_file)
    }

    /// Whether what a scene says of this key counts for nothing over it.
    pub fn rules(&self, key: &str) -> bool {
        self.network.as_ref().is_some_and(|network| network.rules(key))
    }

    /// The scene over it.
    ///
    /// # Errors
    /// A scene that it cannot carry.
    pub fn over(&self, scene: Scene) -> Result<Scene, Error> {
        match &self.network {
            None => Ok(scene),
            Some(network) => network.over(&scene).map_err(|error| format!("over {:?}: {error}", self.name).into()),
        }
    }
}

#[cfg(test)]
#[path = "../../tests/inside/study_network.rs"]
mod tests;
