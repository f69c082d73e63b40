//! `host-sim stability limit`: where one key makes or breaks a scene.

use std::time::Instant;

use clap::Args;
use serde::Serialize;

use crate::cli::{Failure, SceneArgs, Ui};
use haptic_analysis::Range;
use haptic_analysis::{Effort, Limit as Crossings, limit};
use haptic_sim::report::Columns;

/// Arguments of `stability limit`.
#[derive(Debug, Args)]
pub(in crate::cli) struct Limit {
    #[command(flatten)]
    scene: SceneArgs,
    /// The key to change: any number of a scene (`--keys` lists them).
    #[arg(long, value_name = "TABLE.KEY")]
    of: String,
    /// First value.
    #[arg(long, value_name = "A")]
    from: f64,
    /// Last value.
    #[arg(long, value_name = "B")]
    to: f64,
}

#[derive(Serialize)]
struct LimitReport<'a> {
    of: &'a str,
    from: f64,
    to: f64,
    #[serde(flatten)]
    limit: Crossings,
    wall_s: f64,
}

impl Limit {
    /// Answers.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        let (of, from, to) = (self.of.as_str(), self.from, self.to);
        let start = Instant::now();
        let limit = limit(&scene, Range { key: self.of.clone(), from, to }, Effort::default())?;
        let report = LimitReport { of, from, to, limit, wall_s: start.elapsed().as_secs_f64() };
        ui.document_of(&ui.made().settings(scene.settings()), &report)?;
        let word = |stable: bool| if stable { "stable" } else { "unstable" };
        let crossings = &report.limit.crossings;
        let after = |at: usize| report.limit.stable_at_start != (at % 2 == 1);
        let mut rows = vec![(from.to_string(), word(after(0)).to_owned())];
        rows.extend(
            (1..).zip(crossings).map(|(at, key)| (format!("{key:.6}"), format!("{} from here on", word(after(at))))),
        );
        rows.push((to.to_string(), word(after(crossings.len())).to_owned()));
        ui.table(
            &Columns::of(&rows)
                .value(of, |row| row.0.as_str())
                .head(of)
                .shown_in("", 1.0)
                .value("", |row| row.1.as_str())
                .done(),
        );
        Ok(())
    }
}
