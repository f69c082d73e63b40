//! What one run of a sweep gave, and the columns of it.

use cohold_analysis::{Analysis, Conclusion, Judgement};
use cohold_report::{Columns, Rows};
use cohold_sim::run::{Outcome, Verdict};
use cohold_sim::scene::Scene;
use serde::{Deserialize, Serialize};

use super::journal::{self, Kept};
use super::metrics::METRICS;
use crate::Error;

/// What the number of a point means.
pub(super) const POINT: &str = "which point, from 0; in a grid the last key varies fastest, a sample faster still";

/// What one run gave. What is no number there is NaN.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Row {
    /// Index of the point, from 0; in a grid the last key varies fastest.
    pub point: usize,
    /// The seed of the run.
    pub seed: u32,
    /// `stable`, `apart` or `NO`.
    pub verdict: String,
    /// Why it is not stable; empty where it is.
    pub reason: String,
    /// Largest |eigenvalue| of a packet period, both hands on.
    pub spectral_radius: f64,
    /// Which modes that the scene can enter are not stable; empty where all are.
    pub unstable_modes: String,
    /// Figures of merit; NaN where there is none.
    #[serde(rename = "merits")]
    pub metrics: [f64; METRICS.len()],
    /// Hash of both peers' states over every tick that was run ([`Until`](cohold_sim::run::Until)).
    pub state_hash: String,
}

/// What `every_mode_stable` means.
pub(crate) const EVERY_MODE: &str = "whether the scene is stable with both hands on, one and none, at every delay that its network can have, \
                                     and at the walls that it can meet; of the run alone speaks stable";
/// What `unstable_modes` means.
pub(crate) const UNSTABLE_MODES: &str = "which of these are not: whose hands are on (both, one, none)";

impl Row {
    /// What came of the run of a scene.
    pub(super) fn of(point: usize, scene: &Scene, analysis: &Analysis, outcome: Outcome) -> Self {
        let Conclusion { outcome, analysis } = Conclusion::new(scene, outcome, analysis.clone());
        Self {
            point,
            seed: scene.world.network.seed,
            verdict: outcome.verdict().name().to_owned(),
            reason: outcome.reason.map_or_else(String::new, |reason| reason.to_string()),
            spectral_radius: analysis.verdict.spectral_radius,
            unstable_modes: unstable_modes(&analysis.judged),
            metrics: METRICS.map(|metric| (metric.of)(&outcome).unwrap_or(f64::NAN)),
            state_hash: format!("{:016x}", outcome.hash),
        }
    }

    /// Whether the scene is stable in every mode that it can enter.
    pub fn every_mode_stable(&self) -> bool {
        self.unstable_modes.is_empty()
    }

    /// Those in which it is not, if any.
    pub(super) fn unstable_modes(&self) -> Option<&str> {
        said(&self.unstable_modes)
    }

    /// Rows as lines of a file of rows.
    ///
    /// # Errors
    /// A row that cannot be written as CSV.
    pub fn lines(rows: &[Self]) -> Result<Vec<u8>, Error> {
        journal::lines(rows)
    }

    /// The rows that these lines hold, each as it is read.
    pub fn read(lines: &[u8]) -> impl Iterator<Item = csv::Result<Self>> {
        journal::read(lines)
    }
}

/// The modes in which a scene is not stable, as [`Row::unstable_modes`].
pub(crate) fn unstable_modes(judged: &Judgement) -> String {
    judged.unstable_modes().join("; ")
}

/// A figure for a table, which has none where there is no number.
pub(crate) fn known(figure: f64) -> Option<f64> {
    Some(figure).filter(|figure| !figure.is_nan())
}

/// Words for a table, which has nothing where there are none.
pub(crate) fn said(words: &str) -> Option<&str> {
    Some(words).filter(|words| !words.is_empty())
}

impl Kept for Row {
    const ROWS: &'static str = "rows";
    type Key = (usize, u32);

    fn key(&self) -> (usize, u32) {
        (self.point, self.seed)
    }

    /// Those of a run without the keys, which the question holds, and without what the verdict says.
    fn columns() -> Columns {
        of_runs(Columns::of(&[]).value("point", |row: &Self| row.point).means(POINT))
            .without("stable")
            .without("every_mode_stable")
    }
}

/// What every run has, after the columns that say which it is.
pub(crate) fn of_runs(columns: Rows<'_, Row>) -> Columns {
    let mut columns = columns
        .value("seed", |row| row.seed)
        .means("network.seed of the run")
        .value("stable", |row| row.verdict == Verdict::Stable.name())
        .means("whether nobody stopped, nothing grew, the copies stayed together, and no eigenvalue says otherwise")
        .value("verdict", |row| row.verdict.as_str())
        .means("stable, apart or NO")
        .value("reason", |row| said(&row.reason))
        .means("why it is not stable")
        .number("spectral_radius", 6, |row| row.spectral_radius)
        .means("largest |eigenvalue| over a packet period, both hands on; its last bits depend on the processor")
        .value("every_mode_stable", Row::every_mode_stable)
        .means(EVERY_MODE)
        .value("unstable_modes", Row::unstable_modes)
        .means(UNSTABLE_MODES);
    for (at, metric) in METRICS.iter().enumerate() {
        let figure = move |row: &Row| known(row.metrics[at]);
        columns = columns.significant(metric.name(), 4, figure).means(metric.meaning);
    }
    columns
        .value("state_hash", |row| row.state_hash.as_str())
        .means("hash of both peers' states over every tick")
        .done()
}
