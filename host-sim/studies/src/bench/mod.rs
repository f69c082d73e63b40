//! A fair bench of coordination laws: every one tuned by the same search under the same bounds, on networks apart from those of the test.
//!
//! The protocol is docs/results/laws.md, which was written first; what it says in numbers stands in [`protocol`], once, and the page quotes it.
//!
//! | module | what |
//! |---|---|
//! | [`protocol`] | the scene of all, bounds, ranges of gains |
//! | [`crate::networks`] | networks to tune on, others to test on |
//! | [`motions`] | what the hands do |
//! | [`search`] | the tuning of a law: a search of a study |
//! | [`runs`] | the test of a law's gains: every motion over every network |
//! | [`points`] | what the runs of some gains came to |
//! | [`chooser`] | which law is nearest, of all and of those that promise passivity |
//! | [`tables`], [`figure`], [`page`] | how it is shown |
//!
//! **The same rows** come of any number of threads, and of a bench that was stopped and goes on ([`Book`]): a tuning depends on the seed and its
//! number, and on what the tunings of its search before it have found; a run on nothing but its scene.

pub mod chooser;
pub mod figure;
pub mod motions;
pub mod page;
pub mod points;
pub mod protocol;
pub mod runs;
pub mod search;
pub mod tables;

use std::path::{Path, PathBuf};

use cohold_core::settings::{Choice, LawInfo};
use cohold_report::Provenance;
use cohold_sim::peers::Laws;
use rayon::prelude::*;

use self::motions::Motion;
use self::points::Point;
use self::search::Tuning;
use crate::Error;
use crate::networks::Network;
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
    /// Searches of each law, with seeds from 1: each finds other gains, and how far they lie apart is what a search is worth.
    pub searches: u32,
    /// Networks to test on.
    pub networks: Vec<Network>,
    /// Files of networks among them.
    pub traces: Vec<PathBuf>,
}

/// What a bench has found.
#[derive(Clone, Debug, Default)]
pub struct Found {
    /// Every tuning of every law, in their order.
    pub tunings: Vec<Tuning>,
    /// Gains that were tested: of each law its own, and within each bound the best of each search, the best of all first.
    pub points: Vec<Point>,
    /// Searches of each law.
    pub searches: u32,
}

impl Found {
    /// Of each law its own gains, and the best within each bound.
    pub fn best(&self) -> impl Iterator<Item = &Point> + Clone {
        self.points.chunk_by(|one, other| one.law.name == other.law.name && one.name == other.name).map(|same| &same[0])
    }

    /// The least and the most of a figure at what each search found within the bound that this is the best of; without the most where a search found nothing,
    /// or gains at which a run stops.
    pub fn spread(&self, best: &Point, figure: fn(&Point) -> Option<f64>) -> [Option<f64>; 2] {
        let same = self.points.iter().filter(|point| point.law.name == best.law.name && point.name == best.name);
        let figures: Vec<f64> = same.filter(|point| point.stopped() == 0).filter_map(figure).collect();
        let all = figures.len() == self.searches as usize;
        let of = |least: fn(f64, f64) -> f64| figures.iter().copied().reduce(least);
        [of(f64::min), of(f64::max).filter(|_| all)]
    }
}

/// Work of a law that is done: a tuning, or the runs of a motion.
pub type Step<'a> = &'a (dyn Fn() + Sync);

impl Bench {
    /// Steps of the whole bench.
    pub fn steps(&self) -> usize {
        let searches = self.searches as usize;
        let points = 1 + searches * protocol::BOUNDS_N_S_PER_M.len();
        self.chosen.len() * (searches * self.budget + points * Motion::ALL.len())
    }

    /// What is asked, for the files of what it finds.
    ///
    /// # Errors
    /// A trace that cannot be read.
    pub fn question(&self, provenance: Provenance) -> Result<Provenance, Error> {
        let names: Vec<&str> = self.chosen.iter().map(|law| law.name).collect();
        let mut question = provenance.with("number_type", "f64").with("laws", names.join(","));
        question = question.with("budget", self.budget).with("seeds", self.seeds).with("searches", self.searches);
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
        let (tunings, points) = (tunings.into_iter().flatten().collect(), points.into_iter().flatten().collect());
        Ok(Found { tunings, points, searches: self.searches })
    }
}

#[cfg(test)]
#[path = "../../tests/inside/bench.rs"]
mod tests;
