//! Anything that is run point by point, every point with the same seeds: a sweep, a comparison, a study.
//!
//! **The same rows** come of any number of threads, any order and any shard (points I − 1, I − 1 + N, …), to the last bit; the spectral
//! radius alone depends on the processor, by some 10⁻¹⁵ of itself. Points that differ in what is no network are run side by side
//! ([`haptic_sim::lanes`]), which changes no bit.

use std::collections::BTreeSet;

use rayon::prelude::*;

use haptic_analysis::Analysis;
use haptic_sim::lanes::{self, number::LANES};
use haptic_sim::scene::Scene;

use super::row::Row;
use crate::Error;

/// Runs that are to be done: a point, and its seeds.
pub type Todo = Vec<(usize, Vec<u32>)>;

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
    /// and seed.
    ///
    /// # Errors
    /// A scene that cannot be run, or what `keep` refuses.
    fn run(&self, points: impl Iterator<Item = usize>, there: Vec<Row>, keep: Keep<'_>) -> Result<Vec<Row>, Error> {
        let points: BTreeSet<usize> = points.collect();
        let new = self.run_these(self.missing(&points, &there), keep)?;
        let mut rows: Vec<Row> = there.into_iter().filter(|row| points.contains(&row.point)).collect();
        rows.extend(new);
        self.sort(&mut rows);
        Ok(rows)
    }

    /// Runs these seeds of these points, all cores at work, in any order.
    ///
    /// # Errors
    /// A scene that cannot be run, or what `keep` refuses.
    fn run_these(&self, runs: Todo, keep: Keep<'_>) -> Result<Vec<Row>, Error> {
        // Points side by side, as far as every core has some.
        let lanes = (runs.len() / rayon::current_num_threads()).clamp(1, LANES);
        let beside = |some: &[(usize, Vec<u32>)]| run_beside(self, some, keep);
        let rows: Vec<Vec<Row>> = runs.par_chunks(lanes).map(beside).collect::<Result<_, _>>()?;
        Ok(rows.into_iter().flatten().collect())
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
        all.filter(|(_, seeds): &(_, Vec<u32>)| !seeds.is_empty()).collect()
    }
}

/// Runs these points, seed by seed, with the seeds that each lacks.
fn run_beside(plan: &(impl Plan + ?Sized), todo: &[(usize, Vec<u32>)], keep: Keep<'_>) -> Result<Vec<Row>, Error> {
    let of = |(point, seeds): &(usize, Vec<u32>)| {
        let scene = plan.scene_at(*point)?;
        let analysis = Analysis::of(&scene)?;
        Ok::<_, Error>((*point, seeds.iter().copied().collect::<BTreeSet<u32>>(), scene, analysis))
    };
    let points = todo.iter().map(of).collect::<Result<Vec<_>, _>>()?;
    let seeds: BTreeSet<u32> = todo.iter().flat_map(|(_, seeds)| seeds).copied().collect();
    let mut rows = Vec::new();
    for seed in seeds {
        let lacking = || points.iter().filter(|(_, seeds, ..)| seeds.contains(&seed));
        let with_seed = |scene: &Scene| {
            let mut scene = scene.clone();
            scene.world.network.seed = seed;
            scene
        };
        let scenes: Vec<Scene> = lacking().map(|(.., scene, _)| with_seed(scene)).collect();
        let outcomes = lanes::run::<f64>(&scenes, plan.seconds())?;
        let finished = lacking().zip(&scenes).zip(outcomes);
        let row = |(((point, .., analysis), scene), outcome): ((&(usize, _, _, Analysis), &Scene), _)| {
            Row::of(*point, scene, analysis, outcome)
        };
        let new: Vec<Row> = finished.map(row).collect();
        keep(&new)?;
        rows.extend(new);
    }
    Ok(rows)
}
