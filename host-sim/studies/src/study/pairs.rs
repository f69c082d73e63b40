//! The entrants' best points beside each other, seed by seed, on the seeds that judge.
//!
//! **Common networks only**: two entrants are compared on networks where both have a point that may be taken, and on nothing else, so that
//! no entrant looks good for having failed where it is hard. Over all of them together a seed's figure is the mean over the networks, and
//! the interval is that of the seeds.

use super::Study;
use super::answers::{Answer, Goal, by_point, halves};
use crate::paired::Paired;
use crate::sweep::Row;

/// Two entrants at their best points.
#[derive(Clone, Debug)]
pub struct Pair {
    /// Indices of the entrants, the first one first.
    pub entrants: [usize; 2],
    /// The network; none of all that they have in common together.
    pub network: Option<usize>,
    /// Networks on which both have a point: what is compared.
    pub common: Vec<usize>,
    /// The second less the first.
    pub paired: Paired,
}

impl Study {
    /// Every two entrants, network by network and over all that they have in common.
    pub fn pairs(&self, rows: &[Row], answers: &[Answer], goal: &Goal) -> Vec<Pair> {
        let points = by_point(self, rows);
        let judged = |entrant: usize, network: usize| {
            let is_it = |answer: &&Answer| (answer.entrant, answer.network) == (entrant, network);
            let best = answers.iter().find(is_it)?.best.as_ref()?;
            points[best.point].map(|runs| halves(runs).1)
        };
        let pair = |entrants: [usize; 2], network: Option<usize>| {
            let asked = network.map_or(0..self.networks.len(), |network| network..network + 1);
            let both = |network: usize| Some([judged(entrants[0], network)?, judged(entrants[1], network)?]);
            let (common, runs): (Vec<usize>, Vec<_>) =
                asked.filter_map(|network| Some((network, both(network)?))).unzip();
            Pair { entrants, network, common, paired: Paired::of(&runs, goal.metric) }
        };
        let count = self.entrants.len();
        let both = (0..count).flat_map(|first| (first + 1..count).map(move |this| [first, this]));
        let networks = || (0..self.networks.len()).map(Some);
        // Of one network alone there is nothing more to say.
        let together = (self.networks.len() > 1).then_some(None);
        both.flat_map(|entrants| networks().chain(together).map(move |network| pair(entrants, network))).collect()
    }
}
