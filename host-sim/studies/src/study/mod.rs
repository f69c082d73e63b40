//! A study: scenes or laws, over axes, over networks, with the same seeds. Which is best where, under which bounds, and how sure that is.
//!
//! A **point** is an entrant over a network at a point of the grid, which is that of a [`Sweep`]; the grid varies fastest, then the networks.
//! A [`Sweep`] is a study of one entrant on its own network: both are a [`Plan`], and have the same runs, rows and journals.
//!
//! | module | what |
//! |---|---|
//! | [`answers`] | of each entrant on each network the best point under bounds, judged on seeds that did not choose it |
//! | [`halving`] | the search that finds them without all runs |
//! | [`around`] | the search between the points, which the [bench](crate::bench) tunes laws by |
//! | [`pairs`] | the entrants' best points beside each other, seed by seed, on networks where both have one |
//! | [`figure`] | the same as a picture |

pub mod answers;
pub mod around;
pub mod figure;
pub mod halving;
pub mod pairs;
mod tables;

use cohold_report::Provenance;
use cohold_sim::scene::Scene;

use crate::Error;
use crate::entrant::Entrant;
use crate::sweep::{Axis, Plan, Sample, Sweep, check_runs, with_traces};

pub use crate::networks::{Network, OWN};

/// Entrants, networks, axes, seeds and time.
#[derive(Clone, Debug)]
pub struct Study {
    /// Scenes that take part; the first one's seed and those after it are every run's.
    pub entrants: Vec<Entrant>,
    /// Networks that each of them is run over.
    pub networks: Vec<Network>,
    /// Of each entrant the grid on its own network.
    grids: Vec<Sweep>,
}

/// Which point it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Index of the entrant.
    pub entrant: usize,
    /// Index of the network.
    pub network: usize,
    /// Index of the point of the grid.
    pub grid: usize,
}

impl Plan for Study {
    fn points(&self) -> usize {
        self.grids.iter().map(Sweep::points).fold(0, usize::saturating_add).saturating_mul(self.networks.len())
    }

    fn scene_at(&self, point: usize) -> Result<Scene, Error> {
        let Place { entrant, network, grid } = self.place(point);
        let named = |error: Error| Error::from(format!("{}: {error}", self.entrants[entrant].name));
        let scene = self.grids[entrant].scene_at(grid).map_err(named)?;
        let mut scene = self.networks[network].over(&scene).map_err(named)?;
        scene.world.network.seed = self.first_seed();
        Ok(scene)
    }

    fn first_seed(&self) -> u32 {
        self.grids.first().map_or(0, Plan::first_seed)
    }

    fn seeds(&self) -> u32 {
        self.grids.first().map_or(1, Plan::seeds)
    }

    fn seconds(&self) -> f64 {
        self.grids.first().map_or(0.0, Plan::seconds)
    }
}

impl Study {
    /// A study of these entrants over these networks, at every point of the grid of these axes and this sample.
    ///
    /// # Errors
    /// No entrant or no network, or a name that stands there twice.
    pub fn new(
        entrants: Vec<Entrant>,
        networks: Vec<Network>,
        axes: &[Axis],
        sample: Option<&Sample>,
        seeds: u32,
        seconds: f64,
    ) -> Result<Self, Error> {
        let twice = |names: Vec<&str>| {
            let again = |(at, name): (usize, &&str)| names[..at].contains(name);
            names.iter().enumerate().find(|one| again(*one)).map(|(_, name)| (*name).to_owned())
        };
        if let Some(name) = twice(entrants.iter().map(|one| one.name.as_str()).collect()) {
            return Err(format!("{name} takes part twice").into());
        }
        if let Some(name) = twice(networks.iter().map(|one| one.name.as_str()).collect()) {
            return Err(format!("the network {name:?} stands there twice").into());
        }
        if entrants.is_empty() || networks.is_empty() {
            return Err("a study needs a scene or law, and a network".into());
        }
        let grid = |entrant: &Entrant| Sweep {
            scene: entrant.scene.clone(),
            axes: axes.to_vec(),
            sample: sample.cloned(),
            seeds,
            seconds,
        };
        Ok(Self { grids: entrants.iter().map(grid).collect(), entrants, networks })
    }

    /// Refuses what could not be run: as [`Sweep::check`], and a key that is varied where a network rules it.
    ///
    /// # Errors
    /// The first thing that could not be run.
    pub fn check(&self) -> Result<(), Error> {
        for key in self.grid().keys() {
            if let Some(network) = self.networks.iter().find(|network| network.rules(key)) {
                let name = &network.name;
                return Err(format!("{key} is varied, and the network {name:?} rules it: take another network").into());
            }
        }
        self.grid().check_keys()?;
        check_runs(self)?;
        for (entrant, grid) in self.entrants.iter().zip(&self.grids) {
            let wrong = |error: Error| format!("{}: {error}", entrant.name);
            grid.check_points(&|point| {
                let scene = grid.scene_at(point)?;
                self.networks.iter().try_for_each(|network| network.over(&scene).map(drop))
            })
            .map_err(wrong)?;
        }
        Ok(())
    }

    /// Where a point is.
    pub fn place(&self, point: usize) -> Place {
        let grid = self.grid().points().max(1);
        let networks = self.networks.len().max(1);
        Place { entrant: point / grid / networks, network: point / grid % networks, grid: point % grid }
    }

    /// The grid that all entrants have.
    pub fn grid(&self) -> &Sweep {
        &self.grids[0]
    }

    /// What it asks, for its journal and for the files of what it found; traces are identified by their content.
    ///
    /// # Errors
    /// A trace that cannot be read.
    pub fn question(&self, provenance: Provenance) -> Result<Provenance, Error> {
        let provenance = provenance.with("number_type", "f64").with("seconds", self.seconds());
        let mut provenance = Entrant::told(&self.entrants, provenance.with("seeds", self.seeds()));
        for (number, network) in (1..).zip(&self.networks) {
            provenance = provenance.with(&format!("network_{number}"), network.name.as_str());
        }
        let recorded = self.networks.iter().filter_map(|network| network.trace_file().map(Into::into));
        let traces = self.grids.iter().flat_map(Sweep::traces).chain(recorded);
        with_traces(self.grid().varied(provenance), traces)
    }
}
