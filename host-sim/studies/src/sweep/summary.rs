//! The runs of a point as one row: means over the seeds, with half of their 95 % interval.

use haptic_report::{Columns, Rows};
use haptic_sim::run::Verdict;

use super::metrics::METRICS;
use super::row::{EVERY_MODE, Row, UNSTABLE_MODES};
use crate::estimate::Estimate;

/// What every point has, after the columns that say which it is.
pub(crate) fn of_points<'a>(columns: Rows<'a, &'a [Row]>) -> Columns {
    let count = |runs: &[Row], verdict: Verdict| runs.iter().filter(|run| run.verdict == verdict.name()).count();
    let mut columns = columns
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

/// Whether every seed gave the same run.
pub(crate) fn all_same(runs: &[Row]) -> bool {
    runs.iter().all(|run| run.state_hash == runs[0].state_hash)
}

/// A figure of merit over the runs of a point, if every one of them has it.
pub(crate) fn estimate(runs: &[Row], metric: usize) -> Option<Estimate> {
    let values: Vec<f64> = runs.iter().map(|run| run.metrics[metric]).collect();
    if values.iter().any(|value| value.is_nan()) {
        return None;
    }
    let found = Estimate::of(&values);
    Some(Estimate { within_95: found.within_95.filter(|_| !all_same(runs)), ..found })
}
