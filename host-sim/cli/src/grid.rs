//! What is run point by point: its axes, sample, seeds and shard as flags, and the folder that it goes on in.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;
use cohold_report::{Columns, Provenance};
use cohold_sim::run::Until;
use cohold_studies::study::Study;
use cohold_studies::study::answers::Goal;
use cohold_studies::study::halving::LeftOut;
use cohold_studies::sweep;
use cohold_studies::sweep::{Axis, Design, Journal, Plan, Row, Sample, Spread};

use super::flags::choice;
use super::{Failure, Ui};

/// Axes, sample, seeds and shard.
#[derive(Clone, Debug, Args)]
pub(super) struct GridArgs {
    /// A key and its values: N from A to B, at equal ratios with :log, or those of a list; repeat it for a grid.
    #[arg(long, value_name = "TABLE.KEY=A..B:N[:log]|X,Y,Z")]
    pub(super) over: Vec<Axis>,
    /// A key that is drawn from a range, at equal ratios with :log, or from a list; repeat it. At each point of the grid.
    #[arg(long, requires = "points", value_name = "TABLE.KEY=A..B[:log|:whole]|X,Y,Z")]
    sample: Vec<Spread>,
    /// Points of the sample.
    #[arg(long, requires = "sample", value_name = "N")]
    points: Option<usize>,
    /// How they are spread.
    #[arg(long, requires = "sample", default_value = "sobol", value_parser = choice::<Design>())]
    design: Design,
    /// Another sample of the same design.
    #[arg(long, requires = "sample", default_value_t = 1, value_name = "N")]
    sample_seed: u32,
    /// Runs of every point, with the scene's seed and those after it.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(super) seeds: u32,
    /// Only the points of shard I of N, of a search the entrants on networks; without it all, those that shards have done in the same folder
    /// included.
    #[arg(long, default_value = "1/1", value_name = "I/N", value_parser = shard, requires = "out")]
    pub(super) shard: (usize, usize),
}

impl GridArgs {
    /// What is drawn at each point of the grid.
    pub(super) fn sample(&self) -> Result<Option<Sample>, Failure> {
        let sample = |points| Sample::new(self.design, points, self.sample_seed, self.sample.clone());
        Ok(self.points.map(sample).transpose()?)
    }
}

/// The rows of a plan, and the folder that holds them.
pub(super) struct Done {
    pub(super) rows: Vec<Row>,
    /// How many of them were run now, and how long that took, s.
    pub(super) new: usize,
    pub(super) wall_s: f64,
    /// Nothing is to be run any more.
    pub(super) whole: bool,
    folder: Option<PathBuf>,
    journal: Option<Journal>,
}

/// Runs what is missing of a shard of a plan; in a folder it goes on where it was stopped. `name` is what is asked: `sweep`.
pub(super) fn run(
    ui: &Ui,
    plan: &impl Plan,
    until: Until,
    name: &str,
    folder: Option<PathBuf>,
    question: &Provenance,
    shard: (usize, usize),
) -> Result<Done, Failure> {
    let (journal, there) = opened(folder.as_deref(), name, question, shard)?;
    let all: BTreeSet<usize> = plan.points_of(shard).collect();
    let new: usize = plan.missing(&all, &there).iter().map(|(_, seeds)| seeds.len()).sum();
    let (rows, wall_s) = ui.work(new, name, |step| {
        plan.run(until, all.into_iter(), there, &|row| {
            row.iter().for_each(|_| step());
            journal.as_ref().map_or(Ok(()), |journal| journal.append(row))
        })
    })?;
    let whole = rows.len() == plan.runs();
    Ok(Done { rows, new, wall_s, whole, folder, journal })
}

/// Runs what decides the best points of a shard of a study's cells, instead of all; in a folder it goes on where it was stopped. Tells also which
/// points are left out.
pub(super) fn search(
    ui: &Ui,
    study: &Study,
    goal: &Goal,
    folder: Option<PathBuf>,
    question: &Provenance,
    shard: (usize, usize),
) -> Result<(Done, Vec<LeftOut>), Failure> {
    let (journal, there) = opened(folder.as_deref(), "study", question, shard)?;
    // At most so many: it ends earlier.
    let (found, wall_s) = ui.work(study.runs().saturating_sub(there.len()), "study", |step| {
        study.search(goal, shard, there, &|row| {
            row.iter().for_each(|_| step());
            journal.as_ref().map_or(Ok(()), |journal| journal.append(row))
        })
    })?;
    let done = Done { rows: found.rows, new: found.new, wall_s, whole: shard == (1, 1), folder, journal };
    Ok((done, found.left_out))
}

/// The journal of a folder and the rows that it holds; nothing of none.
fn opened(
    folder: Option<&Path>,
    name: &str,
    question: &Provenance,
    shard: (usize, usize),
) -> Result<(Option<Journal>, Vec<Row>), Failure> {
    let Some(folder) = folder else { return Ok((None, Vec::new())) };
    let (journal, rows) = Journal::open(folder, name, question, shard)?;
    Ok((Some(journal), rows))
}

impl Done {
    /// How many of the rows are of runs that are not stable.
    pub(super) fn failed(&self) -> usize {
        self.rows.iter().filter(|row| !row.reason.is_empty()).count()
    }

    /// Number of runs, of all that there are, as a sentence. `more` follows it.
    pub(super) fn said(&self, of: usize, more: &str) -> String {
        let Self { rows, new, wall_s, .. } = self;
        let (runs, failed) = (rows.len(), self.failed());
        format!("{runs} runs of {of}{more}, {failed} of them not stable, {new} new ones in {wall_s:.1} s")
    }

    /// Has the rows reach the disk, and this table of them if they are all that is to be run; returns the files.
    pub(super) fn finish(
        &mut self,
        name: &str,
        question: &Provenance,
        table: impl FnOnce(&[Row]) -> Columns,
    ) -> Result<Vec<PathBuf>, Failure> {
        let files = match &self.folder {
            Some(folder) if self.whole => sweep::write(folder, name, &table(&self.rows), question)?,
            _ => Vec::new(),
        };
        if let Some(journal) = self.journal.take() {
            journal.finish()?;
        }
        Ok(files)
    }
}

/// `I/N` on the command line.
fn shard(text: &str) -> Result<(usize, usize), Failure> {
    let parts = text.split_once('/').and_then(|(shard, shards)| Some((shard.parse().ok()?, shards.parse().ok()?)));
    parts.filter(|(shard, shards)| (1..=*shards).contains(shard)).ok_or_else(|| "write it as I/N, I from 1 to N".into())
}
