//! A scene over its keys and over seeds: a row a run, and per point the mean over the seeds with its 95 % interval.
//!
//! A **point** is one choice of a value for every [`Axis`] of a grid, the last one varying fastest, and at each point of the grid one
//! point of a [`Sample`], which varies faster still. Every point is run with the same seeds: the
//! scene's `network.seed` and those after it. A run is that of `cooperate`, in f64, with what the analyser says of the point
//! (an oscillation may be too slow to grow in a run); its figures of merit are [`METRICS`].
//!
//! **Nothing is chosen**: a run that is not stable is a row with its reason, and a point of which a run has no such figure has no mean
//! of it. There is no interval of a single run, nor where every seed gave the same run.
//!
//! **The same rows** come of any number of threads, any order and any shard (points I − 1, I − 1 + N, …), to the last bit; the spectral
//! radius alone depends on the processor, by some 10⁻¹⁵ of itself. Points that differ in what is no network are run side by side
//! ([`haptic_sim::lanes`]), which changes no bit. [`Journal`] keeps them, so that a sweep goes on where it was stopped.

mod axis;
mod journal;
mod metrics;
mod row;
mod sample;

use std::collections::BTreeSet;
use std::path::Path;

use rayon::prelude::*;
use ring::digest::{SHA256, digest};

use haptic_analysis::{Analysis, Conclusion};
use haptic_core::names::Choice;
use haptic_report::{Columns, Provenance, Rows};
use haptic_sim::lanes::{self, number::LANES};
use haptic_sim::run::{Options, Outcome, Verdict, run};
use haptic_sim::scene::Scene;

use self::row::{POINT, UNSTABLE_MODES};
use super::{Error, estimate::Estimate};

pub use self::axis::Axis;
pub use self::journal::{Journal, Kept, write};
pub use self::metrics::{METRICS, Metric};
pub use self::row::Row;
pub(crate) use self::row::{EVERY_MODE, of_runs};
pub use self::sample::{Design, MOST_KEYS, Sample, Spread};

/// Most runs of a sweep: their rows are held in memory, some 300 bytes each.
pub const MOST_RUNS: usize = 10_000_000;

/// The scene, its axes and samples, and the seeds of a sweep.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// What every point starts from.
    pub scene: Scene,
    /// Keys that are varied over a grid.
    pub axes: Vec<Axis>,
    /// Keys that are drawn at each point of the grid.
    pub sample: Option<Sample>,
    /// Runs of a point.
    pub seeds: u32,
    /// Simulated time of a run, s.
    pub seconds: f64,
}

impl Sweep {
    /// Points: those of the sample at each of the grid.
    pub fn points(&self) -> usize {
        self.axes.iter().map(|axis| axis.values.len()).fold(self.sampled(), usize::saturating_mul)
    }

    /// Points of the sample at each point of the grid.
    fn sampled(&self) -> usize {
        self.sample.as_ref().map_or(1, |sample| sample.points)
    }

    /// Runs of the whole sweep.
    pub fn runs(&self) -> usize {
        self.points().saturating_mul(self.seeds as usize)
    }

    /// What is drawn at each point of the grid.
    fn spreads(&self) -> &[Spread] {
        self.sample.as_ref().map_or(&[], |sample| &sample.spreads)
    }

    /// The keys that are varied.
    pub fn keys(&self) -> impl Iterator<Item = &str> + Clone {
        let drawn = self.spreads().iter().map(|spread| spread.key.as_str());
        self.axes.iter().map(|axis| axis.key.as_str()).chain(drawn)
    }

    /// The value of each of them at a point.
    fn values(&self, point: usize) -> Vec<String> {
        let mut rest = point / self.sampled();
        let digit = |axis: &Axis| {
            let at = rest % axis.values.len();
            rest /= axis.values.len();
            axis.values[at].clone()
        };
        let mut values: Vec<String> = self.axes.iter().rev().map(digit).collect();
        values.reverse();
        if let Some(sample) = &self.sample {
            values.extend((0..sample.spreads.len()).map(|key| sample.value(key, point % sample.points)));
        }
        values
    }

    /// The scene of a point, with the first seed.
    ///
    /// # Errors
    /// A key that does not exist, or a value that it does not accept.
    pub fn scene_at(&self, point: usize) -> Result<Scene, Error> {
        let settings = self.keys().zip(self.values(point)).map(|(key, value)| format!("{key}={value}"));
        let settings: Vec<String> = settings.collect();
        let mut scene = self.scene.clone();
        settings.iter().try_for_each(|setting| scene.apply_override(setting))?;
        scene.check(&settings.join(" "))?;
        Ok(scene)
    }

    /// Refuses what could not be run: a key that there is not, a value or a combination that is not allowed, too much of it.
    ///
    /// # Errors
    /// The first thing that could not be run.
    pub fn check(&self) -> Result<(), Error> {
        for (at, key) in self.keys().enumerate() {
            if key == "network.seed" {
                return Err("network.seed is no key to sweep over: every point is run with the same seeds".into());
            }
            if self.keys().take(at).any(|other| other == key) {
                return Err(format!("{key} is varied twice").into());
            }
        }
        if self.runs() > MOST_RUNS {
            return Err(
                format!("{} points with {} seeds are more than {MOST_RUNS} runs", self.points(), self.seeds).into()
            );
        }
        // What is wrong first, whatever the number of threads.
        let wrong = (0..self.points()).into_par_iter().find_map_first(|point| self.scene_at(point).err());
        wrong.map_or(Ok(()), Err)
    }

    /// What it asks, for [`Journal::open`] and for the files of what it found; traces are identified by their content.
    ///
    /// # Errors
    /// A trace that cannot be read.
    pub fn question(&self, provenance: Provenance) -> Result<Provenance, Error> {
        let mut provenance =
            provenance.settings(self.scene.settings()).with("number_type", "f64").with("seconds", self.seconds);
        provenance = provenance.with("seeds", self.seeds);
        for (number, axis) in (1..).zip(&self.axes) {
            provenance = provenance.with(&format!("over_{number}"), format!("{}={}", axis.key, axis.values.join(",")));
        }
        if let Some(sample) = &self.sample {
            provenance = provenance.with("design", sample.design.name()).with("sample_points", sample.points);
            provenance = provenance.with("sample_seed", sample.seed);
            for (number, spread) in (1..).zip(&sample.spreads) {
                provenance = provenance.with(&format!("sample_{number}"), spread.text());
            }
        }
        let listed = self.axes.iter().map(|axis| (&axis.key, axis.values.as_slice()));
        let listed = listed.chain(self.spreads().iter().map(|spread| (&spread.key, spread.listed())));
        let named =
            listed.filter(|(key, _)| key.ends_with(".trace")).flat_map(|(_, files)| files.iter().map(Into::into));
        let users = self.scene.users.iter().filter_map(|user| user.trace.as_ref().map(|trace| &trace.file));
        let network = self.scene.network_trace.iter().map(|trace| &trace.file);
        let traces = users.chain(network).cloned().chain(named);
        for (number, trace) in (1..).zip(traces) {
            provenance = provenance.with(&format!("trace_{number}_sha256"), sha256_of(&trace)?);
        }
        Ok(provenance)
    }

    /// The points of shard I of N.
    pub fn points_of(&self, (shard, shards): (usize, usize)) -> impl Iterator<Item = usize> {
        (shard - 1..self.points()).step_by(shards)
    }

    /// Runs what `there` lacks of these points, all cores at work; hands every row to `keep` as soon as it is there and returns all of
    /// these points, those that were there included, by point and seed.
    ///
    /// # Errors
    /// A scene that cannot be run, or what `keep` refuses.
    pub fn run(
        &self,
        points: impl Iterator<Item = usize>,
        there: Vec<Row>,
        keep: &(dyn Fn(&[Row]) -> Result<(), Error> + Sync),
    ) -> Result<Vec<Row>, Error> {
        let points: BTreeSet<usize> = points.collect();
        let new = self.run_these(self.missing(&points, &there), keep)?;
        let mut rows: Vec<Row> = there.into_iter().filter(|row| points.contains(&row.point)).collect();
        rows.extend(new);
        self.sort(&mut rows);
        Ok(rows)
    }

    /// Runs these seeds of these points, all cores at work, in any order; `keep` gets every row as soon as it is there, and ends it all
    /// by refusing one.
    ///
    /// # Errors
    /// A scene that cannot be run, or what `keep` refuses.
    pub fn run_these(
        &self,
        runs: Vec<(usize, Vec<u32>)>,
        keep: &(dyn Fn(&[Row]) -> Result<(), Error> + Sync),
    ) -> Result<Vec<Row>, Error> {
        // Points side by side, as far as every core has some.
        let lanes = (runs.len() / rayon::current_num_threads()).clamp(1, LANES);
        let rows: Vec<Vec<Row>> =
            runs.par_chunks(lanes).map(|some| self.run_beside(some, keep)).collect::<Result<_, _>>()?;
        Ok(rows.into_iter().flatten().collect())
    }

    /// By point and seed.
    pub fn sort(&self, rows: &mut [Row]) {
        rows.sort_by_key(|row| (row.point, self.turn(row.seed)));
    }

    /// Runs these points, seed by seed, with the seeds that each lacks.
    fn run_beside(
        &self,
        todo: &[(usize, Vec<u32>)],
        keep: &(dyn Fn(&[Row]) -> Result<(), Error> + Sync),
    ) -> Result<Vec<Row>, Error> {
        let of = |(point, seeds): &(usize, Vec<u32>)| {
            let scene = self.scene_at(*point)?;
            let analysis = Analysis::of(&scene)?;
            Ok::<_, Error>((*point, seeds.iter().copied().collect::<BTreeSet<u32>>(), scene, analysis))
        };
        let points = todo.iter().map(of).collect::<Result<Vec<_>, _>>()?;
        let seeds: BTreeSet<u32> = todo.iter().flat_map(|(_, seeds)| seeds).copied().collect();
        let mut rows = Vec::new();
        for seed in seeds {
            let lacking = || points.iter().filter(|(_, seeds, ..)| seeds.contains(&seed));
            let scenes: Vec<Scene> = lacking().map(|(.., scene, _)| with_seed(scene, seed)).collect();
            let outcomes = lanes::run::<f64>(&scenes, self.seconds)?;
            let finished = lacking().zip(&scenes).zip(outcomes);
            let finished =
                finished.map(|(((point, .., analysis), scene), outcome)| Row::of(*point, scene, analysis, outcome));
            let new: Vec<Row> = finished.collect();
            keep(&new)?;
            rows.extend(new);
        }
        Ok(rows)
    }

    /// The seeds of a point, in their order.
    fn all_seeds(&self) -> impl Iterator<Item = u32> {
        let first = self.scene.world.network.seed;
        (0..self.seeds).map(move |later| first.wrapping_add(later))
    }

    /// Index of the seed among the sweep's seeds.
    fn turn(&self, seed: u32) -> u32 {
        seed.wrapping_sub(self.scene.world.network.seed)
    }

    /// The runs of these points that are not there yet.
    pub fn missing(&self, points: &BTreeSet<usize>, there: &[Row]) -> Vec<(usize, Vec<u32>)> {
        let done: BTreeSet<(usize, u32)> = there.iter().map(|row| (row.point, row.seed)).collect();
        let missing = |point: usize| self.all_seeds().filter(|seed| !done.contains(&(point, *seed))).collect();
        points
            .iter()
            .map(|point| (*point, missing(*point)))
            .filter(|(_, seeds): &(_, Vec<u32>)| !seeds.is_empty())
            .collect()
    }

    /// One column for every key.
    fn of_keys<'a, R>(&self, mut rows: Rows<'a, R>, point: impl Fn(&R) -> usize + Copy) -> Rows<'a, R> {
        let known = self.scene.keys();
        for (at, key) in self.keys().enumerate() {
            let meaning = known.iter().find(|(name, _)| name == key).map_or("a key that is varied", |(_, key)| key.doc);
            rows = rows.value(key, |row| axis::cell(&self.values(point(row))[at])).means(meaning);
        }
        rows
    }

    /// Every run as a table.
    pub fn columns(&self, rows: &[Row]) -> Columns {
        let columns = Columns::of(rows).value("point", |row| row.point).means(POINT);
        of_runs(self.of_keys(columns, |row| row.point))
    }

    /// Every point as a table: means over the seeds, with half of their 95 % interval.
    pub fn summary(&self, rows: &[Row]) -> Columns {
        let points: Vec<&[Row]> = rows.chunk_by(|one, other| one.point == other.point).collect();
        let count = |runs: &[Row], verdict: Verdict| runs.iter().filter(|run| run.verdict == verdict.name()).count();
        let mut columns = Columns::of(&points).value("point", |runs| runs[0].point).means(POINT);
        columns = self
            .of_keys(columns, |runs| runs[0].point)
            .value("runs", |runs| runs.len())
            .means("runs of the point")
            .value("unstable_runs", |runs| count(runs, Verdict::Unstable))
            .means("how many of them are not stable")
            .head("unstable")
            .value("apart_runs", |runs| count(runs, Verdict::Apart))
            .means("in how many of them the copies came apart")
            .head("apart")
            .value("every_mode_stable", |runs| runs[0].every_mode_stable())
            .means(EVERY_MODE)
            .head("let go")
            .value("unstable_modes", |runs| runs[0].unstable_modes())
            .means(UNSTABLE_MODES)
            .data_only();
        for (at, metric) in METRICS.iter().enumerate() {
            let of = |runs: &&[Row]| estimate(runs, at);
            columns = columns.significant(metric.name(), 4, move |runs| of(runs).map(|found| found.mean));
            columns = metric.in_text(columns.means(metric.meaning));
            columns = columns.significant(metric.name_95(), 2, move |runs| of(runs)?.within_95).head("±");
            columns = metric.in_text(columns.means("half of its 95 % interval over the seeds (Student)"));
        }
        let worst = |runs: &&[Row]| {
            let of = |verdict: Verdict| runs.iter().find(|run| run.verdict == verdict.name());
            of(Verdict::Unstable).or(of(Verdict::Apart)).map(|run| run.reason.clone())
        };
        columns.value("reason", worst).means("why the first of the worst runs is not stable").done()
    }
}

impl Row {
    /// One run of a scene with this seed, and what the analyser says of the scene.
    pub(crate) fn of_run(
        point: usize,
        seed: u32,
        scene: &Scene,
        analysis: &Analysis,
        seconds: f64,
    ) -> Result<Self, Error> {
        let scene = with_seed(scene, seed);
        let outcome = run::<f64>(&scene, Options { duration_s: seconds, record_every: 0 }, &|_| {})?;
        Ok(Self::of(point, &scene, analysis, outcome))
    }

    /// What came of the run of a scene.
    fn of(point: usize, scene: &Scene, analysis: &Analysis, outcome: Outcome) -> Self {
        let Conclusion { outcome, analysis } = Conclusion::new(scene, outcome, analysis.clone());
        Self {
            point,
            seed: scene.world.network.seed,
            verdict: outcome.verdict().name().to_owned(),
            reason: outcome.reason.map_or_else(String::new, |reason| reason.to_string()),
            spectral_radius: analysis.verdict.spectral_radius,
            unstable_modes: analysis.judged.unstable_modes().join("; "),
            metrics: METRICS.map(|metric| (metric.of)(&outcome).unwrap_or(f64::NAN)),
            state_hash: format!("{:016x}", outcome.hash),
        }
    }
}

/// This scene with another seed.
fn with_seed(scene: &Scene, seed: u32) -> Scene {
    let mut scene = scene.clone();
    scene.world.network.seed = seed;
    scene
}

/// Whether every seed gave the same run.
pub(crate) fn all_same(runs: &[Row]) -> bool {
    runs.iter().all(|run| run.state_hash == runs[0].state_hash)
}

/// A figure of merit over the runs of a point, if every one of them has it.
fn estimate(runs: &[Row], metric: usize) -> Option<Estimate> {
    let values: Vec<f64> = runs.iter().map(|run| run.metrics[metric]).collect();
    if values.iter().any(|value| value.is_nan()) {
        return None;
    }
    let found = Estimate::of(&values);
    Some(Estimate { within_95: found.within_95.filter(|_| !all_same(runs)), ..found })
}

/// A short text that tells a question from others, whenever it is asked.
pub fn tag(question: &Provenance) -> String {
    let asked = journal::asked(&question.toml()).join("\n");
    hex(&digest(&SHA256, asked.as_bytes()).as_ref()[..4])
}

/// SHA-256 of the content of a trace, in hexadecimal.
pub(crate) fn sha256_of(trace: &Path) -> Result<String, Error> {
    let bytes = haptic_io::read(trace, haptic_sim::user::TRACE);
    let bytes = bytes.map_err(haptic_sim::Error::cannot("read", &trace.display()))?;
    Ok(hex(digest(&SHA256, &bytes).as_ref()))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
