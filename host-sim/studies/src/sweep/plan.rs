//! Anything that is run point by point, every point with the same seeds: a sweep, a comparison, a study.
//!
//! **The same rows** come of any number of threads, any order and any shard (points I − 1, I − 1 + N, …), to the last bit; the spectral
//! radius alone depends on the processor, by some 10⁻¹⁵ of itself. Points and seeds are run side by side ([`cohold_sim::lanes`]),
//! which changes no bit; a point that draws nothing is run with one seed, for all of them are the same.

use std::collections::BTreeSet;

use rayon::prelude::*;

use cohold_analysis::Analysis;
use cohold_sim::lanes::{self, How, number::LANES};
use cohold_sim::run::{Outcome, Until};
use cohold_sim::scene::Scene;

use super::row::Row;
use crate::Error;

/// A point, and the seeds with which it is to be run.
type Lacking = (usize, Vec<u32>);

/// Runs that are to be done.
pub type Todo = Vec<Lacking>;

/// Who gets every row as soon as it is there, and ends it all by refusing one.
pub type Keep<'a> = &'a (dyn Fn(&[Row]) -> Result<(), Error> + Sync);

/// Points, each a scene, and the seeds that each of them is run with.
pub trait Plan: Sync {
    /// How many points there are.
    fn points(&self) -> usize;
    /// The scene of a point, with the first seed.
    ///
    /// # Errors
    /// A key that does not exist, or a value that it does not accept.
    fn scene_at(&self, point: usize) -> Result<Scene, Error>;
    /// The first seed; the others follow it.
    fn first_seed(&self) -> u32;
    /// Runs of a point.
    fn seeds(&self) -> u32;
    /// Simulated time of a run, s.
    fn seconds(&self) -> f64;

    /// Runs of all points.
    fn runs(&self) -> usize {
        self.points().saturating_mul(self.seeds() as usize)
    }

    /// The points of shard I of N.
    fn points_of(&self, (shard, shards): (usize, usize)) -> impl Iterator<Item = usize> {
        (shard - 1..self.points()).step_by(shards)
    }

    /// Runs what `there` lacks of these points, all cores at work; returns all of these points, those that were there included, by point
    /// and seed. If no rows are kept, a run may end when a peer stops: it has no figure of merit then, and its state hash is not reported.
    ///
    /// # Errors
    /// A scene that cannot be run, or what `keep` refuses.
    fn run(
        &self,
        until: Until,
        points: impl Iterator<Item = usize>,
        there: Vec<Row>,
        keep: Keep<'_>,
    ) -> Result<Vec<Row>, Error> {
        let points: BTreeSet<usize> = points.collect();
        let new = run_all(self, until, &self.missing(&points, &there), keep)?;
        let mut rows: Vec<Row> = there.into_iter().filter(|row| points.contains(&row.point)).collect();
        rows.extend(new);
        self.sort(&mut rows);
        Ok(rows)
    }

    /// What a job gives of every point with every seed, all cores at work: by point, and by seed. Where the network draws nothing, with the first seed
    /// alone.
    ///
    /// # Errors
    /// A scene that cannot be run.
    fn each<T: Send>(&self, job: &(dyn Fn(usize, &Scene) -> Result<T, Error> + Sync)) -> Result<Vec<Vec<T>>, Error> {
        let scenes = (0..self.points()).map(|point| self.scene_at(point)).collect::<Result<Vec<Scene>, Error>>()?;
        let seeds = |scene: &Scene| if scene.draws_packets() { self.seeds() } else { 1 };
        let all = scenes.iter().enumerate();
        let runs: Vec<(usize, &Scene, u32)> =
            all.flat_map(|(point, scene)| (0..seeds(scene)).map(move |later| (point, scene, later))).collect();
        let run = |(point, scene, later): (usize, &Scene, u32)| {
            let mut scene = scene.clone();
            scene.world.network.seed = self.first_seed().wrapping_add(later);
            job(point, &scene)
        };
        let mut found = runs.into_par_iter().map(run).collect::<Result<Vec<T>, Error>>()?.into_iter();
        Ok(scenes.iter().map(|scene| found.by_ref().take(seeds(scene) as usize).collect()).collect())
    }

    /// Runs these seeds of these points, all cores at work, in any order.
    ///
    /// # Errors
    /// A scene that cannot be run, or what `keep` refuses.
    fn run_these(&self, runs: Todo, keep: Keep<'_>) -> Result<Vec<Row>, Error> {
        run_all(self, Until::TheEnd, &runs, keep)
    }

    /// By point and seed.
    fn sort(&self, rows: &mut [Row]) {
        rows.sort_by_key(|row| (row.point, row.seed.wrapping_sub(self.first_seed())));
    }

    /// The runs of these points that are not there yet.
    fn missing(&self, points: &BTreeSet<usize>, there: &[Row]) -> Todo {
        let done: BTreeSet<(usize, u32)> = there.iter().map(|row| (row.point, row.seed)).collect();
        let seeds = || (0..self.seeds()).map(|later| self.first_seed().wrapping_add(later));
        let missing = |point: usize| seeds().filter(|seed| !done.contains(&(point, *seed))).collect();
        let all = points.iter().map(|point| (*point, missing(*point)));
        all.filter(|(_, seeds): &Lacking| !seeds.is_empty()).collect()
    }
}

/// Runs these seeds of these points side by side, as far as every core has some.
fn run_all(plan: &(impl Plan + ?Sized), until: Until, runs: &[Lacking], keep: Keep<'_>) -> Result<Vec<Row>, Error> {
    let all: usize = runs.iter().map(|(_, seeds)| seeds.len()).sum();
    let lanes = (all / rayon::current_num_threads()).clamp(1, LANES);
    let beside = |some: &[Lacking]| run_beside(plan, until, some, lanes, keep);
    let rows: Vec<Vec<Row>> = runs.par_chunks(LANES).map(beside).collect::<Result<_, _>>()?;
    Ok(rows.into_iter().flatten().collect())
}

/// A point that is run: its number, the scene that its runs have in common, and what is known of it without a run.
struct Point {
    number: usize,
    scene: Scene,
    analysis: Analysis,
}

/// A run, and the seeds with which it is the same: all of a scene that draws nothing.
struct Same<'a> {
    point: &'a Point,
    scenes: Vec<Scene>,
}

impl<'a> Same<'a> {
    /// The runs of a point with these seeds.
    fn of(point: &'a Point, seeds: &[u32]) -> Vec<Self> {
        let with_seed = |seed: &u32| {
            let mut scene = point.scene.clone();
            scene.world.network.seed = *seed;
            scene
        };
        let each = if point.scene.draws() { 1 } else { seeds.len() };
        seeds.chunks(each).map(|seeds| Self { point, scenes: seeds.iter().map(with_seed).collect() }).collect()
    }

    /// Its rows.
    fn rows(&self, outcome: &Outcome) -> impl Iterator<Item = Row> {
        let Point { number, analysis, .. } = self.point;
        self.scenes.iter().map(|scene| Row::of(*number, scene, analysis, outcome.clone()))
    }
}

/// Runs these points with the seeds that each lacks, so many runs side by side.
fn run_beside(
    plan: &(impl Plan + ?Sized),
    until: Until,
    todo: &[Lacking],
    lanes: usize,
    keep: Keep<'_>,
) -> Result<Vec<Row>, Error> {
    let of = |(number, _): &(usize, _)| {
        let scene = plan.scene_at(*number)?;
        Ok::<_, Error>(Point { number: *number, analysis: Analysis::of(&scene)?, scene })
    };
    let points = todo.par_iter().map(of).collect::<Result<Vec<_>, _>>()?;
    let seeds = todo.iter().map(|(_, seeds)| seeds.as_slice());
    let mut runs: Vec<Same<'_>> = points.iter().zip(seeds).flat_map(|(point, seeds)| Same::of(point, seeds)).collect();
    // Seed by seed: most laws have lanes for points of one seed alone.
    runs.sort_by_key(|run| run.scenes[0].world.network.seed);
    let beside = |runs: &[Same<'_>]| {
        let scenes: Vec<Scene> = runs.iter().map(|run| run.scenes[0].clone()).collect();
        let outcomes = lanes::run(How::until(until), &scenes, plan.seconds())?;
        let new: Vec<Row> = runs.iter().zip(&outcomes).flat_map(|(run, outcome)| run.rows(outcome)).collect();
        keep(&new)?;
        Ok(new)
    };
    let rows: Vec<Vec<Row>> = runs.par_chunks(lanes).map(beside).collect::<Result<_, Error>>()?;
    Ok(rows.into_iter().flatten().collect())
}
