//! The runs of a point as one row: means over the seeds, with half of their 95 % interval.

use cohold_report::{Columns, Rows};
use cohold_sim::run::Verdict;

use super::metrics::METRICS;
use super::row::{EVERY_MODE, Row, UNSTABLE_MODES, said};
use crate::estimate::Estimate;

/// The runs of a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Summed<'a> {
    /// Which point it is.
    pub(crate) point: usize,
    /// Its runs; none of one that a search left out.
    pub(crate) runs: &'a [Row],
    /// Modes in which it is not stable, as [`Row::unstable_modes`].
    pub(crate) unstable_modes: &'a str,
}

impl<'a> Summed<'a> {
    /// Of rows in the order of their points, point by point.
    pub(crate) fn each(rows: &'a [Row]) -> Vec<Self> {
        let of = |runs: &'a [Row]| Self { point: runs[0].point, runs, unstable_modes: &runs[0].unstable_modes };
        rows.chunk_by(|one, other| one.point == other.point).map(of).collect()
    }

    fn count(&self, verdict: Verdict) -> usize {
        self.runs.iter().filter(|run| run.verdict == verdict.name()).count()
    }

    /// Why the first of the worst runs is not stable, or why there is none.
    fn reason(&self) -> Option<String> {
        let of = |verdict: Verdict| self.runs.iter().find(|run| run.verdict == verdict.name());
        let worst = of(Verdict::Unstable).or(of(Verdict::Apart)).map(|run| run.reason.clone());
        worst.or_else(|| {
            self.runs.is_empty().then(|| format!("not run: not stable with these hands on: {}", self.unstable_modes))
        })
    }
}

/// What every point has, after the columns that say which it is.
pub(crate) fn of_points<'a>(columns: Rows<'a, Summed<'a>>) -> Columns {
    let mut columns = columns
        .value("runs", |point| point.runs.len())
        .means("runs of the point; 0 where a search left it out, because it is not stable in every mode")
        .value("unstable_runs", |point| point.count(Verdict::Unstable))
        .means("how many of them are not stable")
        .head("unstable")
        .value("apart_runs", |point| point.count(Verdict::Apart))
        .means("in how many of them the copies came apart")
        .head("apart")
        .value("every_mode_stable", |point| point.unstable_modes.is_empty())
        .means(EVERY_MODE)
        .head("let go")
        .data("unstable_modes", |point| said(point.unstable_modes))
        .means(UNSTABLE_MODES);
    for (at, metric) in METRICS.iter().enumerate() {
        let of = |point: &Summed<'_>| estimate(point.runs, at);
        columns = columns.significant(metric.name(), 4, move |point| of(point).map(|found| found.mean));
        columns = metric.in_text(columns.means(metric.meaning));
        columns = columns.significant(metric.named("_95"), 2, move |point| of(point)?.within_95).head("±");
        columns = metric.in_text(columns.means("half of its 95 % interval over the seeds (Student)"));
    }
    let columns = columns.value("reason", Summed::reason);
    columns.means("why the first of the worst runs is not stable, or why there is no run").done()
}

/// Whether every seed gave the same run.
pub(crate) fn all_same(runs: &[Row]) -> bool {
    runs.iter().all(|run| run.state_hash == runs[0].state_hash)
}

/// A figure of merit over the runs of a point, if it has some and every one of them has it.
pub(crate) fn estimate(runs: &[Row], metric: usize) -> Option<Estimate> {
    let values: Vec<f64> = runs.iter().map(|run| run.metrics[metric]).collect();
    if values.is_empty() || values.iter().any(|value| value.is_nan()) {
        return None;
    }
    let found = Estimate::of(&values);
    Some(Estimate { within_95: found.within_95.filter(|_| !all_same(runs)), ..found })
}
