//! Successive halving: seeds go to the points between which they still have to decide.
//!
//! A **cell** is an entrant on a network. What the analyser says is not stable in every mode may not be taken, and is not run. All other points
//! of a cell are run with one of the seeds that choose, then those that are left with two, four, eight and so on. After each round goes what may not be taken, which no further seed could change; and of the others, ranked by their means so far, those
//! of the worse half that the seeds tell from the best one (their paired difference leaves out 0 in its 95 % interval, as in [`Paired`]). Those
//! left when all seeds that choose are spent are run with those that judge. If none of them may be taken then, who went last comes back: where
//! the whole grid has a point that may be taken, so has this.
//!
//! **The same whatever is there**: a round decides by its own seeds, not by runs that another question left in the folder; and a cell by its
//! own runs, so that shard I of N is the cells I − 1, I − 1 + N, ….
//!
//! **What is promised**: the point, mean and interval of the grid, unless the point that is best over all choosing seeds was told from another one
//! by the first of them. How often that was, and how many runs there are of the grid's, law by law: `tests/data/halving.txt`.
//!
//! The halves: Jamieson and Talwalkar, *Non-stochastic best arm identification and hyperparameter optimization* (AISTATS 2016); only what is told
//! from the best one goes: Maron and Moore, *Hoeffding races* (NIPS 1993), here with Student's interval of pairs.

use std::collections::BTreeMap;

use cohold_analysis::judge;
use rayon::prelude::*;

use super::Study;
use super::answers::{Goal, Standing, choosing};
use crate::Error;
use crate::paired::Paired;
use crate::sweep::{Keep, Plan, Row, Todo, estimate, unstable_modes};

cohold_sim::choices! {
    /// Which runs a study does.
    Search {
        "grid" => Grid, "Every point with every seed.";
        "halving" => Halving, "What decides the best point under a goal.";
    }
}

/// A point that a search did not run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// Which point it is.
    pub point: usize,
    /// The modes in which it is not stable.
    pub unstable_modes: String,
}

/// What a search has run.
#[derive(Clone, Debug)]
pub struct Searched {
    /// The runs that it decided by, by point and seed.
    pub rows: Vec<Row>,
    /// The points that it did not run, in their order.
    pub left_out: Vec<LeftOut>,
    /// How many of them were not there before.
    pub new: usize,
}

/// The points of an entrant on a network.
struct Cell {
    live: Vec<usize>,
    /// Those that went as worse, round by round.
    gone: Vec<Vec<usize>>,
}

/// Runs by point, each point's in the order of its seeds.
struct Runs<'a> {
    study: &'a Study,
    rows: BTreeMap<(usize, u32), Row>,
    /// Of each point how many seeds were asked for.
    asked: BTreeMap<usize, u32>,
    keep: Keep<'a>,
    new: usize,
}

impl Runs<'_> {
    /// Has so many seeds of these points.
    fn extend(&mut self, points: impl Iterator<Item = usize>, seeds: u32) -> Result<(), Error> {
        let mut todo = Todo::new();
        for point in points {
            self.asked.insert(point, seeds);
            let lacks = |later: &u32| !self.rows.contains_key(&(point, *later));
            let lacking = (0..seeds).filter(lacks).map(|later| self.study.first_seed().wrapping_add(later));
            let lacking: Vec<u32> = lacking.collect();
            if !lacking.is_empty() {
                todo.push((point, lacking));
            }
        }
        let new = self.study.run_these(todo, self.keep)?;
        self.new += new.len();
        self.add(new);
        Ok(())
    }

    fn add(&mut self, rows: Vec<Row>) {
        let first = self.study.first_seed();
        self.rows.extend(rows.into_iter().map(|row| ((row.point, row.seed.wrapping_sub(first)), row)));
    }

    /// Those of these points, in their order, that are not stable in every mode: what its first run found, or else the analyser says.
    fn left_out(&self, points: &[usize]) -> Result<Vec<LeftOut>, Error> {
        let of = |point: &usize| {
            let judged = || Ok::<_, Error>(unstable_modes(&judge(&self.study.scene_at(*point)?)?));
            let known = |row: &Row| Ok(row.unstable_modes.clone());
            let unstable_modes = self.rows.get(&(*point, 0)).map_or_else(judged, known)?;
            Ok((!unstable_modes.is_empty()).then_some(LeftOut { point: *point, unstable_modes }))
        };
        let found = points.par_iter().map(of);
        found.filter_map(Result::transpose).collect()
    }

    /// The first so many seeds of a point.
    fn of(&self, point: usize, seeds: u32) -> Vec<Row> {
        self.rows.range((point, 0)..(point, seeds)).map(|(_, row)| row.clone()).collect()
    }
}

impl Cell {
    /// What is decided after a round of so many seeds.
    fn decide(&mut self, runs: &Runs<'_>, seeds: u32, goal: &Goal) {
        let of = |point: &usize| (*point, runs.of(*point, seeds));
        let mut ranked: Vec<(usize, Vec<Row>)> = self.live.iter().map(of).collect();
        ranked.retain(|(_, runs)| goal.standing(runs) == Standing::Allowed);
        let mean = |runs: &[Row]| estimate(runs, goal.metric).map_or(f64::NAN, |found| found.mean);
        // Of equals the first one leads, as in the answer.
        ranked.sort_by(|(_, one), (_, other)| mean(one).total_cmp(&mean(other)));
        let half = ranked.len().div_ceil(2);
        let is_told = |(_, runs): &(usize, Vec<Row>)| {
            // One seed tells nothing apart.
            seeds > 1 && Paired::of(&[[&ranked[0].1, runs]], goal.metric).differs() == Some(true)
        };
        let (gone, worse): (Vec<_>, Vec<_>) = ranked[half..].iter().partition(|one| is_told(one));
        let place = |one: &(usize, Vec<Row>)| one.0;
        self.gone.push(gone.into_iter().map(place).collect());
        self.live = ranked[..half].iter().chain(worse).map(place).collect();
    }

    /// Whether a point may be taken that has all its seeds; else the last that went are back.
    fn is_decided(&mut self, runs: &Runs<'_>, goal: &Goal) -> bool {
        let all = runs.study.seeds();
        let allowed = |point: &usize| goal.standing(&runs.of(*point, all)) == Standing::Allowed;
        if self.live.iter().any(allowed) {
            return true;
        }
        let Some(back) = self.gone.pop() else { return true };
        self.live = back;
        false
    }
}

/// Seeds of each round: doubled up to those that choose.
fn rounds(choosing: u32) -> impl Iterator<Item = u32> {
    let doubled = std::iter::successors(Some(1_u32), |seeds| seeds.checked_mul(2));
    doubled.take_while(move |seeds| *seeds < choosing).chain([choosing])
}

impl Study {
    /// Runs what decides the best point of each entrant on each network of shard I of N, all cores at work; of `there` it takes what it needs.
    ///
    /// # Errors
    /// A scene that cannot be run, or what `keep` refuses.
    pub fn search(
        &self,
        goal: &Goal,
        (shard, shards): (usize, usize),
        there: Vec<Row>,
        keep: Keep<'_>,
    ) -> Result<Searched, Error> {
        let mut runs = Runs { study: self, rows: BTreeMap::new(), asked: BTreeMap::new(), keep, new: 0 };
        runs.add(there);
        let (all, grid) = ((0..self.points()).collect::<Vec<_>>(), self.grid().points().max(1));
        let mine: Vec<&[usize]> = all.chunks(grid).skip(shard - 1).step_by(shards).collect();
        let left_out = runs.left_out(&mine.concat())?;
        let is_run = |point: &usize| left_out.binary_search_by_key(point, |one| one.point).is_err();
        let cell = |points: &&[usize]| Cell { live: points.iter().copied().filter(is_run).collect(), gone: Vec::new() };
        let mut cells: Vec<Cell> = mine.iter().map(cell).collect();
        for seeds in rounds(choosing(self.seeds())) {
            runs.extend(cells.iter().flat_map(|cell| cell.live.iter().copied()), seeds)?;
            cells.iter_mut().for_each(|cell| cell.decide(&runs, seeds, goal));
        }
        while !cells.is_empty() {
            runs.extend(cells.iter().flat_map(|cell| cell.live.iter().copied()), self.seeds())?;
            cells.retain_mut(|cell| !cell.is_decided(&runs, goal));
        }
        let rows = runs.asked.iter().flat_map(|(point, seeds)| runs.of(*point, *seeds)).collect();
        Ok(Searched { rows, left_out, new: runs.new })
    }
}
