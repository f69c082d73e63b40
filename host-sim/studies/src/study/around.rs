//! A search between the points of a grid: half of its tries spread over the ranges of all gains, the others around the best so far.
//!
//! | tries | gains |
//! |---|---|
//! | number 0 | none: as they are |
//! | up to half of the budget | points of Sobol's sequence over the ranges |
//! | the rest, in five rounds | the best within one of the bounds, in turn, about half of its gains moved at random: by 0.15 of a range (standard deviation) at first, each round by 0.6 of the last |
//!
//! What a try is measured by, and what it costs, says who asks ([`Tried`]). A try **counts** whatever comes of it. **The same tries** come of
//! any number of threads: the gains of one depend on the seed, on its number, and on what the rounds before it have found.

use cohold_sim::rng::Rng;
use rayon::prelude::*;

use crate::Error;
use crate::sweep::{Design, Sample};

/// Rounds around the best.
const ROUNDS: usize = 5;
/// How far a gain is moved in the first of them (standard deviation), of its range.
const STEP: f64 = 0.15;
/// And by how much less in each next one.
const SHRINK: f64 = 0.6;

/// A gain and between which ends it is tuned: equal ratios alike, or equal differences where it may be 0 or less.
#[derive(Clone, Debug, PartialEq)]
pub struct Gain {
    /// The key of a scene.
    pub key: String,
    /// Its ends.
    pub ends: [f64; 2],
    /// Whether it is a whole number.
    pub whole: bool,
}

impl Gain {
    /// The value at this share of the range, from 0 to 1, as a scene file writes it: four digits that count.
    pub fn value(&self, share: f64) -> String {
        let [low, high] = self.ends;
        // libm: the same bits on every machine.
        let value = if low > 0.0 { low * libm::pow(high / low, share) } else { low + (high - low) * share };
        if self.whole { format!("{}", value.round()) } else { short(value) }
    }

    /// Where in the range this value lies; outside, its nearer end.
    pub fn share(&self, value: f64) -> f64 {
        let [low, high] = self.ends;
        let share =
            if low > 0.0 { libm::log(value / low) / libm::log(high / low) } else { (value - low) / (high - low) };
        share.clamp(0.0, 1.0)
    }
}

/// Four digits that count.
fn short(value: f64) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    format!("{rounded:?}")
}

/// What came of a try.
pub trait Tried: Clone + Send {
    /// Its gains as settings with blanks between; empty of number 0.
    fn gains(&self) -> &str;
    /// What is to be least within a bound.
    fn cost(&self, bound: f64) -> f64;
}

/// The best within a bound, the first of equals.
pub fn best<T: Tried>(tried: &[T], bound: f64) -> Option<&T> {
    tried.iter().min_by(|one, other| one.cost(bound).total_cmp(&other.cost(bound)))
}

/// What is searched.
#[derive(Clone, Copy, Debug)]
pub struct Around<'a> {
    /// Gains and their ranges.
    pub gains: &'a [Gain],
    /// Of each of them its value at number 0.
    pub own: &'a [f64],
    /// Within which the best are looked for.
    pub bounds: &'a [f64],
    /// Number of tries.
    pub budget: usize,
    /// Of the sequence and of the moves.
    pub seed: u32,
}

impl Around<'_> {
    /// All tries, in their order; `attempt` measures one by its number and its gains.
    ///
    /// # Errors
    /// More gains than a sample can spread, or what `attempt` says.
    pub fn search<T: Tried>(
        &self,
        attempt: &(dyn Fn(usize, String) -> Result<T, Error> + Sync),
    ) -> Result<Vec<T>, Error> {
        let ranges = self.gains.iter().map(|gain| format!("{}=0..1", gain.key).parse());
        let random = (self.budget / 2).max(1);
        let sample = Sample::new(Design::Sobol, random, self.seed, ranges.collect::<Result<_, _>>()?)?;
        let spread = |index: usize| self.text(|key| sample.place(key, index));
        let first = std::iter::once(String::new()).chain((1..random).map(spread)).take(self.budget);
        let mut tried = all(0, first.collect(), attempt)?;
        for round in 0..ROUNDS {
            let some = self.budget.saturating_sub(tried.len()).div_ceil(ROUNDS - round);
            let around = |at: usize| {
                let bound = self.bounds[at % self.bounds.len()];
                let from = best(&tried, bound).map_or("", T::gains);
                let mut random = Rng::new(u64::from(self.seed) << 32 ^ (tried.len() + at) as u64);
                self.moved(from, STEP * SHRINK.powi(round as i32), &mut random)
            };
            let texts = (0..some).map(around).collect();
            tried.extend(all(tried.len(), texts, attempt)?);
        }
        Ok(tried)
    }

    /// Gains at these shares of their ranges.
    fn text(&self, mut share: impl FnMut(usize) -> f64) -> String {
        let setting = |(at, gain): (usize, &Gain)| format!("{}={}", gain.key, gain.value(share(at)));
        self.gains.iter().enumerate().map(setting).collect::<Vec<_>>().join(" ")
    }

    /// These gains, about half of them moved by this share of their ranges (standard deviation), at least one.
    fn moved(&self, from: &str, by: f64, random: &mut Rng) -> String {
        let one = random.below(self.gains.len() as u64) as usize;
        self.text(|at| {
            let gain = &self.gains[at];
            let set = from.split_whitespace().find_map(|setting| setting.strip_prefix(&gain.key)?.strip_prefix('='));
            let value = set.and_then(|text| text.parse().ok()).unwrap_or(self.own[at]);
            let (is_moved, way) = (random.chance(0.5) || at == one, random.normal());
            let share = gain.share(value.max(gain.ends[0]));
            if is_moved { (share + by * way).clamp(0.0, 1.0) } else { share }
        })
    }
}

/// These tries side by side, the first of this number.
fn all<T: Send>(
    first: usize,
    texts: Vec<String>,
    attempt: &(dyn Fn(usize, String) -> Result<T, Error> + Sync),
) -> Result<Vec<T>, Error> {
    texts.into_par_iter().enumerate().map(|(at, gains)| attempt(first + at, gains)).collect()
}

#[cfg(test)]
#[path = "../../tests/inside/around.rs"]
mod tests;
