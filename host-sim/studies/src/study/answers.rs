//! Of each entrant on each network the best point: the least of a figure of merit among the points that may be taken at all.
//!
//! **May be taken** is a point of which every run is stable and has the figure, which is stable in every mode that its scene can enter, and
//! of which no run is beyond a bound. What a point fails first, in this order, it is counted under.
//!
//! **Honest** about its luck: the best of many points is in part the luckiest, so the first half of the seeds chooses and the other half
//! says how good it is. A single seed does both. The interval is Student's over the seeds that judge; there is none where every seed gave
//! the same run.
//!
//! **The next** is the point that comes closest to the best one, and how far from it it is: over the seeds that judge, or where a search gave it up
//! over the choosing seeds that it had, which favour the best one.
//!
//! **As good** are the points that may be taken and whose paired difference from the best, on the seeds that judge, does not leave out 0.

use std::str::FromStr;

use cohold_report::Provenance;
use cohold_sim::run::Verdict;

use super::halving::LeftOut;
use super::{Place, Study};
use crate::Error;
use crate::estimate::Estimate;
use crate::paired::Paired;
use crate::sweep::{METRICS, Plan, Row, estimate};

/// What is asked of the points.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// Index in [`METRICS`] of what is to be least.
    pub metric: usize,
    /// What may be this much at most in every run.
    pub bounds: Vec<Bound>,
}

/// A figure of merit and the most that it may be in any run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// Index in [`METRICS`].
    pub metric: usize,
    /// In its unit.
    pub most: f64,
}

/// The index of the figure of merit of this name.
///
/// # Errors
/// A name that none has.
pub fn metric(name: &str) -> Result<usize, Error> {
    let names: Vec<String> = METRICS.iter().map(|metric| metric.name()).collect();
    names.iter().position(|known| known == name).ok_or_else(|| format!("they are {}", names.join(", ")).into())
}

impl FromStr for Bound {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let (name, most) = text.split_once('=').ok_or("write it as NAME=MOST, NAME a figure of merit")?;
        let most = most.trim().parse().ok().filter(|most: &f64| most.is_finite());
        let most = most.ok_or("MOST must be a number, in the unit of the figure of merit")?;
        Ok(Self { metric: metric(name.trim())?, most })
    }
}

/// What there is to take.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Points of the grid.
    pub points: usize,
    /// Of which a run is not stable, or has no such figure.
    pub failed: usize,
    /// Of the others, those that are not stable in every mode.
    pub let_go: usize,
    /// Of the others, those of which a run is beyond a bound.
    pub beyond: usize,
    /// Of the others, those that a search gave up as worse before they had all their seeds ([`super::halving`]).
    pub given_up: usize,
}

impl Counts {
    /// Points that may be taken.
    pub fn allowed(&self) -> usize {
        self.points - self.failed - self.let_go - self.beyond - self.given_up
    }

    fn add(&mut self, standing: Standing) {
        self.points += 1;
        match standing {
            Standing::Allowed => {}
            Standing::Failed => self.failed += 1,
            Standing::LetGo => self.let_go += 1,
            Standing::Beyond => self.beyond += 1,
            Standing::GivenUp => self.given_up += 1,
        }
    }
}

/// How a point stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Standing {
    Allowed,
    Failed,
    LetGo,
    Beyond,
    GivenUp,
}

/// An entrant on a network.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Index of the entrant.
    pub entrant: usize,
    /// Index of the network.
    pub network: usize,
    /// How its points stand.
    pub counts: Counts,
    /// The best point; none where none may be taken.
    pub best: Option<Best>,
}

/// The best point of an entrant on a network.
#[derive(Clone, Debug)]
pub struct Best {
    /// Index of the point of the study.
    pub point: usize,
    /// Its figure on the seeds that judge.
    pub judged: Estimate,
    /// How many these are.
    pub seeds: usize,
    /// Points that are as good, this one included: indices of the grid.
    pub as_good: Vec<usize>,
    /// The runner-up, where there is another point that may be taken, or that a search gave up as worse.
    pub next: Option<Next>,
}

/// The point that comes closest to the best one by the seeds that choose.
#[derive(Clone, Debug)]
pub struct Next {
    /// Index of the grid.
    pub grid: usize,
    /// Its figure less the best one's, seed by seed.
    pub difference: Estimate,
    /// Over how many seeds.
    pub seeds: usize,
    /// Whether they judge; else a search gave it up after so many of those that choose.
    pub judged: bool,
}

/// How many of so many seeds choose; the others judge, and a single one does both.
pub(super) fn choosing(seeds: u32) -> u32 {
    (seeds / 2).max(1)
}

/// The runs of these seeds that choose, and those that judge.
pub(super) fn halves(runs: &[Row]) -> (&[Row], &[Row]) {
    let (choose, judge) = runs.split_at(runs.len().min(choosing(runs.len() as u32) as usize));
    if judge.is_empty() { (choose, choose) } else { (choose, judge) }
}

/// The runs that there are of each point.
pub(super) fn by_point<'a>(study: &Study, rows: &'a [Row]) -> Vec<Option<&'a [Row]>> {
    let mut points = vec![None; study.points()];
    for runs in rows.chunk_by(|one, other| one.point == other.point) {
        points[runs[0].point] = Some(runs);
    }
    points
}

impl Goal {
    /// What is to be least, and under which bounds: `NAME, NAME at most MOST in any run`.
    pub fn what(&self) -> String {
        METRICS[self.metric].name() + &self.bounds_told()
    }

    /// The bounds, each after a comma.
    fn bounds_told(&self) -> String {
        let bound = |bound: &Bound| format!(", {} at most {} in any run", METRICS[bound.metric].name(), bound.most);
        self.bounds.iter().map(bound).collect()
    }

    /// With which figures of merit and bounds this is asked, for files of what was found.
    pub fn told(&self, question: Provenance) -> Provenance {
        question.with("best", METRICS[self.metric].name()).with("at_most", self.bounds_told())
    }

    /// How a point stands whose runs these are.
    pub(super) fn standing(&self, runs: &[Row]) -> Standing {
        let has = |run: &Row, metric: usize| !run.metrics[metric].is_nan();
        let needs = || self.bounds.iter().map(|bound| bound.metric).chain([self.metric]);
        let failed = |run: &Row| run.verdict != Verdict::Stable.name() || needs().any(|metric| !has(run, metric));
        let beyond = |run: &Row| self.bounds.iter().any(|bound| run.metrics[bound.metric] > bound.most);
        match () {
            () if runs.iter().any(failed) => Standing::Failed,
            () if !runs.iter().all(Row::every_mode_stable) => Standing::LetGo,
            () if runs.iter().any(beyond) => Standing::Beyond,
            () => Standing::Allowed,
        }
    }
}

impl Study {
    /// The answer of every entrant on every network whose runs are all there; rows by point and seed.
    pub fn answers(&self, rows: &[Row], goal: &Goal) -> Vec<Answer> {
        self.answers_of(by_point(self, rows), goal, self.seeds() as usize)
    }

    /// The answers of a [`Study::search`] for this goal, from what it has run and what it has left out.
    pub fn searched_answers(&self, rows: &[Row], left_out: &[LeftOut], goal: &Goal) -> Vec<Answer> {
        let mut points = by_point(self, rows);
        left_out.iter().for_each(|one| points[one.point] = Some(&[]));
        self.answers_of(points, goal, 0)
    }

    /// The answer of every entrant on every network whose points have so many runs each.
    fn answers_of(&self, points: Vec<Option<&[Row]>>, goal: &Goal, least: usize) -> Vec<Answer> {
        let grid = self.grid().points().max(1);
        let whole = |runs: &[Option<&[Row]>]| runs.iter().all(|runs| runs.is_some_and(|runs| runs.len() >= least));
        let cells = points.chunks(grid).enumerate().filter(|(_, runs)| whole(runs));
        cells
            .map(|(cell, runs)| self.answer(cell * grid, &runs.iter().flatten().copied().collect::<Vec<_>>(), goal))
            .collect()
    }

    /// The answer of the entrant on the network whose first point this is; a point without runs was left out.
    fn answer(&self, first: usize, points: &[&[Row]], goal: &Goal) -> Answer {
        let Place { entrant, network, .. } = self.place(first);
        let mut counts = Counts::default();
        let all = self.seeds() as usize;
        let standings = points.iter().map(|runs| match goal.standing(runs) {
            _ if runs.is_empty() => Standing::LetGo,
            Standing::Allowed if runs.len() < all => Standing::GivenUp,
            other => other,
        });
        let standings: Vec<Standing> = standings.inspect(|standing| counts.add(*standing)).collect();
        let allowed = || (0..points.len()).filter(|grid| standings[*grid] == Standing::Allowed);
        let chosen_by =
            |grid: usize| estimate(halves(points[grid]).0, goal.metric).map_or(f64::NAN, |found| found.mean);
        let best = allowed().min_by(|one, other| chosen_by(*one).total_cmp(&chosen_by(*other)));
        let best = best.and_then(|best| {
            let judge = halves(points[best]).1;
            let same = |grid: &usize| {
                let paired = Paired::of(&[[judge, halves(points[*grid]).1]], goal.metric);
                *grid == best || paired.differs() == Some(false)
            };
            let as_good = allowed().filter(same).collect();
            let others = (0..points.len())
                .filter(|grid| *grid != best && matches!(standings[*grid], Standing::Allowed | Standing::GivenUp));
            let next = next(points, best, others, goal.metric, all);
            let judged = estimate(judge, goal.metric)?;
            Some(Best { point: first + best, judged, seeds: judge.len(), as_good, next })
        });
        Answer { entrant, network, counts, best }
    }
}

/// Which of the others comes closest to the best one; they have all seeds, or the first few of those that choose.
fn next(
    points: &[&[Row]],
    best: usize,
    others: impl Iterator<Item = usize>,
    metric: usize,
    all: usize,
) -> Option<Next> {
    // Of pairs of runs as far as both have them.
    let further = |best: &[Row], runs: &[Row]| Paired::of(&[[best, runs]], metric).difference;
    let (choose, judge) = halves(points[best]);
    let is_judged = |grid: usize| points[grid].len() == all;
    let chosen = |grid: usize| if is_judged(grid) { halves(points[grid]).0 } else { points[grid] };
    let by = |grid: usize| further(choose, chosen(grid)).map_or(f64::NAN, |found| found.mean);
    let grid = others.min_by(|one, other| by(*one).total_cmp(&by(*other)))?;
    let judged = is_judged(grid);
    let (of, runs) = if judged { (judge, halves(points[grid]).1) } else { (choose, points[grid]) };
    Some(Next { grid, difference: further(of, runs)?, seeds: runs.len(), judged })
}
