//! `host-sim stability map`: the region in two keys.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use serde::Serialize;

use crate::cli::flags::Out;
use crate::cli::{Failure, SceneArgs, Ui};

use haptic_analysis::Effort;
use haptic_analysis::picture;
use haptic_analysis::{Axis, Column, map};
use haptic_sim::report::Columns;

/// Arguments of `stability map`.
#[derive(Debug, Args)]
pub(in crate::cli) struct Map {
    #[command(flatten)]
    scene: SceneArgs,
    /// Horizontal axis: key, first and last value, how many.
    #[arg(long, value_name = "KEY=A..B:N")]
    x: Axis,
    /// Vertical axis; along it all crossings are found, N is the grid of the picture.
    #[arg(long, value_name = "KEY=A..B:N")]
    y: Axis,
    #[command(flatten)]
    out: Out,
}

#[derive(Serialize)]
struct MapReport<'a> {
    x: &'a str,
    y: &'a str,
    y_from: f64,
    y_to: f64,
    columns: &'a [Column],
    evaluations: usize,
    wall_s: f64,
    files: Vec<PathBuf>,
}

impl Map {
    /// Answers.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        let bar = ui.progress(self.x.count as u64, "columns");
        let start = Instant::now();
        let effort = Effort { steps: (2 * self.y.count).max(200), ..Effort::default() };
        let found = map(&scene, [self.x.clone(), self.y.clone()], effort, || bar.inc(1))?;
        let wall_s = start.elapsed().as_secs_f64();
        bar.finish_and_clear();
        let made = ui.made().settings(scene.settings());
        let name = format!("map-{}-{}-{}", self.scene.run_name(&scene), self.x.range.key, self.y.range.key);
        let folder = ui.folder(self.out.folder(), "out/stability");
        let files = ui.files(folder.as_deref(), &name, &made, |files| {
            files.csv(&found.table())?;
            files.figure(None, &picture::region(&format!("Stability region of {}", self.scene.name()), &found))
        })?;
        let report = MapReport {
            x: &self.x.range.key,
            y: &self.y.range.key,
            y_from: self.y.range.from,
            y_to: self.y.range.to,
            columns: &found.columns,
            evaluations: found.evaluations(),
            wall_s,
            files,
        };
        ui.document_of(&made, &report)?;
        let table = Columns::of(report.columns)
            .number(report.x, 5, |column| column.x)
            .head(report.x)
            .shown_in("", 1.0)
            .value("start", |column| if column.limit.stable_at_start { "stable" } else { "unstable" })
            .head("at the lowest")
            .number(report.y, 5, |column| column.limit.crossings.clone())
            .head(report.y)
            .shown_in("", 1.0)
            .done();
        writeln!(ui, "{table}\n{} spectral radii in {wall_s:.2} s", report.evaluations);
        ui.wrote(&report.files);
        Ok(())
    }
}
