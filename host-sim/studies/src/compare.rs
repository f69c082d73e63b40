//! Scenes beside each other, run with the same seeds: how their figures of merit differ, run by run, with 95 % intervals.
//!
//! The first scene is what the others are compared with. A **difference** is a scene's figure less the first one's of the same seed:
//! what the network does to both cancels, as far as their packets meet the same losses. Its mean has Student's interval over the
//! seeds; each interval is of one comparison, so of twenty that mean nothing one lies beside 0.
//!
//! **Nothing is chosen**: where a run of either scene has no such figure there is no difference, but the reason; the runs themselves are
//! all there as rows. No interval where every seed gave the same runs, nor of a single seed.

use haptic_plot::{Dash, Figure, Panel, Series};
use haptic_report::{Columns, label};
use haptic_sim::scene::Scene;

use super::Error;
use super::entrant::Entrant;
use super::estimate::Estimate;
use super::sweep::{METRICS, Plan, Row, all_same, of_runs};

/// Scenes, seeds and duration of a comparison.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Two or more; the first is what the others are compared with.
    pub entrants: Vec<Entrant>,
    /// Seeds: that of the first scene and those after it.
    pub seeds: u32,
    /// Simulated time of a run, s.
    pub seconds: f64,
}

/// One figure of merit of one scene beside the first one's.
#[derive(Clone, Debug)]
pub struct Difference {
    /// Index of the scene, from 1.
    pub entrant: usize,
    /// Index of the figure of merit in [`METRICS`].
    pub metric: usize,
    /// Means over the seeds, of the first scene and of this one, where every run has it.
    pub means: [Option<f64>; 2],
    /// This one's less the first one's, seed by seed.
    pub difference: Option<Estimate>,
    /// Why there is none: the first run of either that failed.
    pub reason: Option<String>,
}

impl Difference {
    /// Whether they differ, as [`Paired::differs`].
    pub fn differs(&self) -> Option<bool> {
        Paired { means: self.means, difference: self.difference }.differs()
    }
}

/// A point is a scene; the first seed is the first scene's.
impl Plan for Comparison {
    fn points(&self) -> usize {
        self.entrants.len()
    }

    fn scene_at(&self, point: usize) -> Result<Scene, Error> {
        Ok(self.entrants[point].scene.clone())
    }

    fn first_seed(&self) -> u32 {
        self.entrants.first().map_or(0, |entrant| entrant.scene.world.network.seed)
    }

    fn seeds(&self) -> u32 {
        self.seeds
    }

    fn seconds(&self) -> f64 {
        self.seconds
    }
}

impl Comparison {
    /// Every scene after the first beside it, in all figures of merit.
    pub fn differences(&self, rows: &[Row]) -> Vec<Difference> {
        let runs: Vec<&[Row]> = rows.chunk_by(|one, other| one.point == other.point).collect();
        let of = |entrant| (0..METRICS.len()).map(move |metric| (entrant, metric));
        let pairs = (1..runs.len()).flat_map(of);
        pairs.map(|(entrant, metric)| difference([runs[0], runs[entrant]], entrant, metric)).collect()
    }

    /// Every run as a table.
    pub fn runs(&self, rows: &[Row]) -> Columns {
        let columns = Columns::of(rows).value("number", |row| row.point + 1).means("which scene, from 1");
        of_runs(columns.value("scene", |row| self.entrants[row.point].name.as_str()).means("name of the scene or law"))
    }

    /// The differences as a table; in text these figures of merit.
    pub fn columns(&self, differences: &[Difference], shown: &[usize]) -> Columns {
        let shown: Vec<&Difference> = differences.iter().filter(|one| shown.contains(&one.metric)).collect();
        let relative = |one: &&Difference| {
            let percent = 100.0 * one.difference?.mean / one.means[0]?.abs();
            Some(percent).filter(|percent| percent.is_finite())
        };
        Columns::of(&shown)
            .value("number", |one| one.entrant + 1)
            .means("which scene, from 1")
            .data_only()
            .value("scene", |one| self.entrants[one.entrant].name.as_str())
            .means("name of the scene or law")
            .value("merit", |one| METRICS[one.metric].name())
            .means("figure of merit; what follows is in its unit")
            .significant("first", 4, |one| one.means[0])
            .means("mean over the seeds, of the first scene")
            .significant("this", 4, |one| one.means[1])
            .means("mean over the seeds, of this scene")
            .significant("difference", 3, |one| one.difference.map(|found| found.mean))
            .means("this scene less the first, mean over the seeds")
            .significant("difference_95", 2, |one| one.difference?.within_95)
            .head("±")
            .means("half of the 95 % interval of the mean of the paired differences (Student)")
            .number("relative_percent", 1, relative)
            .means("the difference, of the first scene's mean")
            .head("")
            .shown_in("%", 1.0)
            .value("differs", |one| one.differs())
            .means("whether the interval leaves out 0")
            .value("reason", |one| one.reason.clone())
            .means("why there is no difference: the first run of either that failed")
            .done()
    }

    /// Intervals of the differences, a panel for each of these figures of merit.
    pub fn figure(&self, differences: &[Difference], shown: &[usize]) -> Figure {
        let others = self.entrants.len() - 1;
        let panel = |metric: &usize| {
            let of: Vec<&Difference> = differences.iter().filter(|one| one.metric == *metric).collect();
            let interval = |one: &&Difference| {
                let found = one.difference?;
                Some((one.entrant as f64 - 1.0, found.mean, found.within_95.unwrap_or(0.0)))
            };
            let failed = of.iter().filter(|one| one.difference.is_none()).count();
            let zero = vec![(-0.6, 0.0), (others as f64 - 0.4, 0.0)];
            Panel {
                y_label: label(&METRICS[*metric].name()),
                categories: self.entrants[1..].iter().map(|entrant| entrant.name.replace(',', ", ")).collect(),
                note: (failed > 0).then(|| format!("{failed} without: a run failed")),
                series: vec![
                    Series::dashed("", 6, Dash::Dotted, zero),
                    Series::intervals("", 0, of.iter().filter_map(interval).collect()),
                ],
                ..Panel::default()
            }
        };
        Figure {
            title: format!("Differences from {}", self.entrants[0].name.replace(',', ", ")),
            caption: format!(
                "Means of paired differences with their 95 % intervals (Student), {} seeds, {} s each. Each interval is of one \
                 comparison. A scene without a mark had a run that failed.",
                self.seeds, self.seconds
            ),
            columns: if shown.len() == 4 { 2 } else { shown.len().clamp(1, 3) },
            panels: shown.iter().map(panel).collect(),
            ..Figure::default()
        }
    }
}

/// A figure of merit of two sets of runs, seed by seed: their means, and how the second differs from the first, where every run has it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Paired {
    /// Means over the seeds.
    pub means: [Option<f64>; 2],
    /// The second less the first; without an interval where every seed gave the same runs.
    pub difference: Option<Estimate>,
}

impl Paired {
    /// Over one pair of runs of the same seeds, or the mean over several.
    pub fn of(pairs: &[[&[Row]; 2]], metric: usize) -> Self {
        let seeds = pairs.iter().flatten().map(|runs| runs.len()).min().unwrap_or(0);
        let value = |which: usize, seed: usize| {
            pairs.iter().map(|pair| pair[which][seed].metrics[metric]).sum::<f64>() / pairs.len() as f64
        };
        let values = [0, 1].map(|which| {
            let values: Vec<f64> = (0..seeds).map(|seed| value(which, seed)).collect();
            Some(values).filter(|values| !values.is_empty() && !values.iter().any(|value| value.is_nan()))
        });
        let sure = pairs.iter().flatten().all(|runs| all_same(runs));
        let difference = values[0].as_ref().zip(values[1].as_ref()).map(|(first, this)| {
            let differences: Vec<f64> = this.iter().zip(first).map(|(this, first)| this - first).collect();
            let found = Estimate::of(&differences);
            Estimate { within_95: found.within_95.filter(|_| !sure), ..found }
        });
        Self { means: values.map(|values| values.map(|values| Estimate::of(&values).mean)), difference }
    }

    /// Whether the interval leaves out 0; where there is none because nothing is random, whether they differ.
    pub fn differs(&self) -> Option<bool> {
        self.difference.map(|found| found.mean.abs() > found.within_95.unwrap_or(0.0))
    }
}

/// One figure of merit of two scenes' runs, seed by seed.
fn difference(runs: [&[Row]; 2], entrant: usize, metric: usize) -> Difference {
    let paired = Paired::of(&[runs], metric);
    let failed = || runs.into_iter().flatten().find(|run| run.metrics[metric].is_nan() && !run.reason.is_empty());
    Difference {
        entrant,
        metric,
        means: paired.means,
        reason: if paired.difference.is_some() { None } else { failed().map(|run| run.reason.clone()) },
        difference: paired.difference,
    }
}

#[cfg(test)]
#[path = "../tests/inside/compare.rs"]
mod tests;
