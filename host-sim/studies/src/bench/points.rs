//! What the runs of some gains of a law came to, over all networks and seeds.
//!
//! A network counts with the mean of its seeds, a law with its worst network; a peak with the largest of every run. Where a run stopped there is no mean
//! of its network, and so no worst one: it is said how many stopped, and what did not is no consolation.

use cohold_core::names::Choice;
use cohold_core::settings::LawInfo;

use super::motions::Motion;
use super::runs::Run;
use super::search::Tuning;
use crate::accuracy::counts::Processor;

/// Some gains of a law, tested.
#[derive(Clone, Debug)]
pub struct Point {
    /// The law.
    pub law: &'static LawInfo,
    /// Name of the gains: `declared`, or the bound within which they are the best.
    pub name: String,
    /// The gains, and what tuning found of them.
    pub tuning: Tuning,
    /// Every run of theirs.
    pub runs: Vec<Run>,
}

impl Point {
    /// Its runs of a motion.
    fn of(&self, motion: Motion) -> impl Iterator<Item = &Run> + Clone {
        self.runs.iter().filter(move |run| run.motion == motion.name())
    }

    /// The mean over the seeds of each network, by name.
    fn networks(&self, motion: Motion, of: fn(&Run) -> f64) -> Vec<(&str, f64)> {
        let runs: Vec<&Run> = self.of(motion).collect();
        let networks = runs.chunk_by(|one, other| one.network == other.network);
        let mean = |runs: &[&Run]| runs.iter().map(|run| of(run)).sum::<f64>() / runs.len() as f64;
        networks.map(|runs| (runs[0].network.as_str(), mean(runs))).collect()
    }

    /// The worst network and its mean; none where a run of any stopped.
    pub fn worst_network(&self, motion: Motion, of: fn(&Run) -> f64) -> Option<(&str, f64)> {
        let networks = self.networks(motion, of);
        let all = networks.iter().all(|(_, mean)| !mean.is_nan());
        networks.into_iter().max_by(|one, other| one.1.total_cmp(&other.1)).filter(|_| all)
    }

    /// The least mean of any network; none where a run of any stopped.
    pub fn least(&self, motion: Motion, of: fn(&Run) -> f64) -> Option<f64> {
        let networks = self.networks(motion, of);
        let all = networks.iter().all(|(_, mean)| !mean.is_nan());
        networks.into_iter().map(|(_, mean)| mean).reduce(f64::min).filter(|_| all)
    }

    /// The largest of any run, those that stopped among them.
    pub fn most(&self, motion: Motion, of: fn(&Run) -> f64) -> f64 {
        self.of(motion).map(of).fold(0.0, f64::max)
    }

    /// Distance of the copies over the force of contact under pushes against each other, worst network, mm/N.
    pub fn worst_mm_per_n(&self) -> Option<f64> {
        self.worst_network(Motion::Against, |run| run.mm_per_n).map(|(_, mean)| mean)
    }

    /// Runs in which a peer stopped or something grew.
    pub fn stopped(&self) -> usize {
        self.runs.iter().filter(|run| run.stopped).count()
    }

    /// Why the first of them did.
    pub fn reason(&self) -> Option<String> {
        let first = self.runs.iter().find(|run| run.stopped);
        first.map(|run| format!("{} over {}: {}", run.motion, run.network, run.reason))
    }

    /// Least balance of the energy of the link in any run, J.
    pub fn least_balance_j(&self) -> f64 {
        self.runs.iter().map(|run| run.least_balance_j).fold(0.0, f64::min)
    }

    /// Mean of all runs.
    pub fn mean(&self, of: fn(&Run) -> f64) -> f64 {
        self.runs.iter().map(of).sum::<f64>() / self.runs.len() as f64
    }

    /// Instructions of a tick in f32 on a Cortex-M7, if it was counted.
    pub fn instructions(&self) -> Option<u64> {
        Processor::CortexM7.count(&format!("law/{}", self.law.name), "f32")
    }
}
