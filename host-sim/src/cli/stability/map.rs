//! `host-sim stability map`: the region in two keys.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use serde::Serialize;

use super::super::ui::save;
use super::super::{Failure, SceneArgs, Ui};

use haptic_analysis::Effort;
use haptic_analysis::picture;
use haptic_analysis::{Axis, Column, map};
use haptic_plot::draw;
use haptic_sim::report::text::TextTable;

/// Arguments of `stability map`.
#[derive(Debug, Args)]
pub(super) struct Map {
    #[command(flatten)]
    scene: SceneArgs,
    /// Horizontal axis: key, first and last value, how many.
    #[arg(long, value_name = "KEY=A..B:N")]
    x: Axis,
    /// Vertical axis; along it all crossings are found, N is the grid of the picture.
    #[arg(long, value_name = "KEY=A..B:N")]
    y: Axis,
    /// Folder for CSV and picture.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
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
    ///
    /// # Errors
    /// A bad scene, key or range; a file that cannot be written.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load()?;
        let bar = ui.progress(self.x.count as u64, "columns");
        let start = Instant::now();
        let effort = Effort { steps: (2 * self.y.count).max(200), ..Effort::default() };
        let found = map(&scene, [self.x.clone(), self.y.clone()], effort, || bar.inc(1))?;
        let wall_s = start.elapsed().as_secs_f64();
        bar.finish_and_clear();
        let mut written = Vec::new();
        if let Some(folder) = ui.folder(self.out.as_deref(), "out/stability") {
            let base = folder.join(format!("map-{}", self.scene.name()));
            let title = format!("Stability region of {}", self.scene.name());
            written = save(&base, &found.table()?, || draw(&picture::region(&title, &found), &base))?;
        }
        let report = MapReport {
            x: &self.x.range.key,
            y: &self.y.range.key,
            y_from: self.y.range.from,
            y_to: self.y.range.to,
            columns: &found.columns,
            evaluations: found.evaluations(),
            wall_s,
            files: written,
        };
        ui.document(&report)?;
        let mut table = TextTable::new([report.x, "at the lowest", report.y]);
        for Column { x, limit } in report.columns {
            let crossings: Vec<String> = limit.crossings.iter().map(|crossing| format!("{crossing:.5}")).collect();
            let start = if limit.stable_at_start { "stable" } else { "unstable" };
            table.push([format!("{x:.5}"), start.to_owned(), crossings.join(" ")]);
        }
        writeln!(ui, "{table}\n{} spectral radii in {wall_s:.2} s", report.evaluations);
        ui.wrote(&report.files);
        Ok(())
    }
}
