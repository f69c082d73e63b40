//! A fair bench of coordination laws: every one tuned by the same search under the same bounds, on networks apart from those of the test.
//!
//! The protocol is docs/bench.md, which was written first; what it says in numbers stands in [`protocol`], once, and the page quotes it.
//!
//! | module | what |
//! |---|---|
//! | [`protocol`] | the scene of all, bounds, ranges of gains |
//! | [`networks`] | networks to tune on, others to test on |
//! | [`motions`] | what the hands do |
//! | [`search`] | the tuning of a law: a search of a study |
//! | [`runs`] | the test of a law's gains: every motion over every network |
//! | [`points`] | what the runs of some gains came to |
//! | [`tables`], [`figure`], [`page`] | how it is shown |
//!
//! **The same rows** come of any number of threads, and of a bench that was stopped and goes on ([`Book`]): a tuning depends on the seed and its
//! number, and on what the law's own tunings before it have found; a run on nothing but its scene.

pub mod figure;
pub mod motions;
pub mod networks;
pub mod page;
pub mod points;
pub mod protocol;
pub mod runs;
pub mod search;
pub mod tables;

use std::path::{Path, PathBuf};

use haptic_core::settings::{Choice, LawInfo};
use haptic_report::Provenance;
use haptic_sim::peers::Laws;
use rayon::prelude::*;

use self::motions::Motion;
use self::networks::Network;
use self::points::Point;
use self::search::Tuning;
use crate::Error;
use crate::sweep::{Book, with_traces};

/// A bench: which laws, and how much of it.
#[derive(Clone, Debug)]
pub struct Bench {
    /// Laws that scenes may name.
    pub laws: Laws,
    /// The laws that are benched.
    pub chosen: Vec<&'static LawInfo>,
    /// Tunings of each law.
    pub budget: usize,
    /// Runs over each network that draws random numbers.
    pub seeds: u32,
    /// Seed of the search.
    pub search_seed: u32,
    /// Networks to test on.
    pub networks: Vec<Network>,
    /// Files of networks among them.
    pub traces: Vec<PathBuf>,
}

/// What a bench has found.
#[derive(Clone, Debug)]
pub struct Found {
    /// Every tuning of every law, in their order.
    pub tunings: Vec<Tuning>,
    /// Gains that were tested: of each law its own, and the best within each bound.
    pub points: Vec<Point>,
}

/// Work of a law that is done: a tuning, or the runs of a motion.
pub type Step<'a> = &'a (dyn Fn() + Sync);

impl Bench {
    /// Steps of the whole bench.
    pub fn steps(&self) -> usize {
        self.chosen.len() * (self.budget + (1 + protocol::BOUNDS_N_S_PER_M.len()) * Motion::ALL.len())
    }

    /// What is asked, for the files of what it finds.
    ///
    /// # Errors
    /// A trace that cannot be read.
    pub fn question(&self, provenance: Provenance) -> Result<Provenance, Error> {
        let names: Vec<&str> = self.chosen.iter().map(|law| law.name).collect();
        let mut question = provenance.with("number_type", "f64").with("laws", names.join(","));
        question = question.with("budget", self.budget).with("seeds", self.seeds).with("search_seed", self.search_seed);
        let networks: Vec<&str> = self.networks.iter().map(|network| network.name.as_str()).collect();
        question = question.with("networks", networks.join(", "));
        with_traces(question, &self.traces)
    }

    /// Tunes and tests all laws; in `folder` it goes on where it was stopped. `step` is called at most [`Bench::steps`] times.
    ///
    /// # Errors
    /// A folder of another bench, a file that cannot be written, a scene that cannot be built at the gains that its law declares.
    pub fn run(&self, folder: Option<(&Path, &Provenance)>, step: Step<'_>) -> Result<Found, Error> {
        let (tunings, runs) = (Book::open(folder, "bench")?, Book::open(folder, "bench")?);
        let of_law = |law: &&'static LawInfo| {
            let found = search::tune(self, law, &tunings, step)?;
            let tested = |(name, tuning): (String, Tuning)| {
                let runs = runs::test(self, law, &name, &tuning, &runs, step)?;
                Ok::<_, Error>(Point { law, name, tuning, runs })
            };
            let points = search::chosen(&found).into_par_iter().map(tested).collect::<Result<Vec<_>, _>>()?;
            Ok::<_, Error>((found, points))
        };
        let found = self.chosen.par_iter().map(of_law).collect::<Result<Vec<_>, _>>()?;
        tunings.finish()?;
        runs.finish()?;
        let (tunings, points): (Vec<_>, Vec<_>) = found.into_iter().unzip();
        Ok(Found { tunings: tunings.into_iter().flatten().collect(), points: points.into_iter().flatten().collect() })
    }
}

#[cfg(test)]
#[path = "../../tests/inside/bench.rs"]
mod tests;
