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
//! How it is run, in any order and on any number of threads, is that of every [`Plan`]. [`Journal`] keeps the rows, so that a sweep goes on
//! where it was stopped.

mod axis;
mod journal;
mod metrics;
mod plan;
mod row;
mod sample;
mod summary;

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use ring::digest::{SHA256, digest};

use cohold_core::names::Choice;
use cohold_core::settings::{Allowed, Key};
use cohold_report::{Cell, Columns, Holds, Provenance, Rows};
use cohold_sim::scene::Scene;

use self::row::POINT;
use super::Error;

pub use self::axis::Axis;
pub use self::journal::{Book, Journal, Kept, write};
pub use self::metrics::{METRICS, Metric, bytes_per_s};
pub use self::plan::{Keep, Plan, Todo};
pub use self::row::Row;
pub(crate) use self::row::{EVERY_MODE, UNSTABLE_MODES, known, of_runs, said, unstable_modes};
pub use self::sample::{Design, MOST_KEYS, Sample, Spread};
pub(crate) use self::summary::{Summed, all_same, estimate, of_points};

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

impl Plan for Sweep {
    /// Those of the sample at each of the grid.
    fn points(&self) -> usize {
        self.axes.iter().map(|axis| axis.values.len()).fold(self.sampled(), usize::saturating_mul)
    }

    fn scene_at(&self, point: usize) -> Result<Scene, Error> {
        let settings = self.keys().zip(self.values(point)).map(|(key, value)| format!("{key}={value}"));
        let settings: Vec<String> = settings.collect();
        let mut scene = self.scene.clone();
        settings.iter().try_for_each(|setting| scene.apply_override(setting))?;
        scene.check(&settings.join(" "))?;
        Ok(scene)
    }

    fn first_seed(&self) -> u32 {
        self.scene.world.network.seed
    }

    fn seeds(&self) -> u32 {
        self.seeds
    }

    fn seconds(&self) -> f64 {
        self.seconds
    }
}

impl Sweep {
    /// Points of the sample at each point of the grid.
    fn sampled(&self) -> usize {
        self.sample.as_ref().map_or(1, |sample| sample.points)
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
    pub(crate) fn values(&self, point: usize) -> Vec<String> {
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

    /// Refuses what could not be run: a key that there is not, a value or a combination that is not allowed, too much of it.
    ///
    /// # Errors
    /// The first thing that could not be run.
    pub fn check(&self) -> Result<(), Error> {
        self.check_keys()?;
        check_runs(self)?;
        self.check_points(&|point| self.scene_at(point).map(drop))
    }

    /// Refuses a key that is none to vary.
    pub(crate) fn check_keys(&self) -> Result<(), Error> {
        for (at, key) in self.keys().enumerate() {
            if key == "network.seed" {
                return Err("network.seed is no key to sweep over: every point is run with the same seeds".into());
            }
            if self.keys().take(at).any(|other| other == key) {
                return Err(format!("{key} is varied twice").into());
            }
        }
        Ok(())
    }

    /// What is wrong first, whatever the number of threads.
    pub(crate) fn check_points(&self, wrong: &(dyn Fn(usize) -> Result<(), Error> + Sync)) -> Result<(), Error> {
        let first = (0..self.points()).into_par_iter().find_map_first(|point| wrong(point).err());
        first.map_or(Ok(()), Err)
    }

    /// What it asks, for [`Journal::open`] and for the files of what it found; traces are identified by their content.
    ///
    /// # Errors
    /// A trace that cannot be read.
    pub fn question(&self, provenance: Provenance) -> Result<Provenance, Error> {
        let provenance = provenance.settings(self.scene.settings()).with("number_type", "f64");
        let provenance = self.varied(provenance.with("seconds", self.seconds).with("seeds", self.seeds));
        with_traces(provenance, self.traces())
    }

    /// What is varied.
    pub(crate) fn varied(&self, mut provenance: Provenance) -> Provenance {
        for (number, axis) in (1..).zip(&self.axes) {
            provenance = provenance.with(&format!("over_{number}"), format!("{}={}", axis.key, axis.values.join(",")));
        }
        if let Some(sample) = &self.sample {
            provenance = provenance.with("design", sample.design.name()).with("sample_points", sample.points);
            provenance = provenance.with("sample_seed", sample.seed);
            for (number, spread) in (1..).zip(&sample.spreads) {
                provenance = provenance.with(&format!("sample_{number}"), spread.text.as_str());
            }
        }
        provenance
    }

    /// Every trace that a run may read.
    pub(crate) fn traces(&self) -> Vec<PathBuf> {
        let listed = self.axes.iter().map(|axis| (&axis.key, axis.values.as_slice()));
        let listed = listed.chain(self.spreads().iter().map(|spread| (&spread.key, spread.listed())));
        let named =
            listed.filter(|(key, _)| key.ends_with(".trace")).flat_map(|(_, files)| files.iter().map(Into::into));
        let users = self.scene.users.iter().filter_map(|user| user.trace.as_ref().map(|trace| &trace.file));
        let network = self.scene.network_trace.iter().map(|trace| &trace.file);
        users.chain(network).cloned().chain(named).collect()
    }

    /// One column for every key.
    pub(crate) fn of_keys<'a, R>(
        &self,
        mut rows: Rows<'a, R>,
        point: impl Fn(&R) -> Option<usize> + Copy,
    ) -> Rows<'a, R> {
        for (at, key) in self.keys().enumerate() {
            let holds = self.holds(key);
            let cell = |row: &R| point(row).map_or(Cell::Empty, |point| self.cell(point, at, holds));
            rows = rows.cells(key, holds, cell).means(self.known(key).map_or("a key that is varied", |key| key.doc));
        }
        rows
    }

    /// Every run as a table.
    pub fn columns(&self, rows: &[Row]) -> Columns {
        let columns = Columns::of(rows).value("point", |row| row.point).means(POINT);
        of_runs(self.of_keys(columns, |row| Some(row.point)))
    }

    /// Every point as a table: means over the seeds, with half of their 95 % interval.
    pub fn summary(&self, rows: &[Row]) -> Columns {
        let points = Summed::each(rows);
        let columns = Columns::of(&points).value("point", |point| point.point).means(POINT);
        of_points(self.of_keys(columns, |point| Some(point.point)))
    }

    /// What a scene accepts for a key, be it one end's alone; nothing of one that names a file.
    fn known(&self, key: &str) -> Option<Key> {
        let of_both = key.strip_prefix("peer.").and_then(|own| own.split_once('.')).map_or(key, |(_, of_both)| of_both);
        self.scene.keys().into_iter().find_map(|(name, known)| (name == of_both).then_some(known))
    }

    /// What a column of this key's values holds: what a scene accepts for it, and texts where that is not of one sort.
    pub(crate) fn holds(&self, key: &str) -> Holds {
        match self.known(key).map(|key| key.allowed) {
            Some(Allowed::Number { .. }) => Holds::Numbers,
            Some(Allowed::Whole { .. }) => Holds::Counts,
            Some(Allowed::Flag) => Holds::Flags,
            _ => Holds::Texts,
        }
    }

    /// The value of a key at a point, as a cell of a column that holds this.
    pub(crate) fn cell(&self, point: usize, key: usize, holds: Holds) -> Cell {
        axis::cell(&self.values(point)[key], holds)
    }
}

/// Refuses more runs than memory holds.
pub(crate) fn check_runs(plan: &impl Plan) -> Result<(), Error> {
    if plan.runs() > MOST_RUNS {
        let (points, seeds) = (plan.points(), plan.seeds());
        return Err(format!("{points} points with {seeds} seeds are more than {MOST_RUNS} runs").into());
    }
    Ok(())
}

/// A short text that tells a question from others, whenever it is asked.
pub fn tag(question: &Provenance) -> String {
    let asked = journal::asked(&question.toml()).join("\n");
    hex(&digest(&SHA256, asked.as_bytes()).as_ref()[..4])
}

/// With what identifies these traces.
pub(crate) fn with_traces(
    mut provenance: Provenance,
    traces: impl IntoIterator<Item = impl AsRef<Path>>,
) -> Result<Provenance, Error> {
    for (number, trace) in (1..).zip(traces) {
        provenance = provenance.with(&format!("trace_{number}_sha256"), sha256_of(trace.as_ref())?);
    }
    Ok(provenance)
}

/// SHA-256 of the content of a trace, in hexadecimal.
fn sha256_of(trace: &Path) -> Result<String, Error> {
    let bytes = cohold_io::read(trace, cohold_sim::user::TRACE);
    let bytes = bytes.map_err(cohold_sim::Error::cannot("read", &trace.display()))?;
    Ok(hex(digest(&SHA256, &bytes).as_ref()))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
