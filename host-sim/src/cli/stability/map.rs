//! `host-sim stability map`: the region in two keys.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use serde::Serialize;

use super::super::{Failure, SceneArgs, print_json, progress_bar};
use super::{folder, tell, write};
use haptic_analysis::limit::Effort;
use haptic_analysis::map::{Axis, Column, map};
use haptic_analysis::picture;
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
    /// Print JSON; files are written only with --out.
    #[arg(long)]
    json: bool,
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
    pub(super) fn run(&self) -> Result<(), Failure> {
        let scene = self.scene.load()?;
        let bar = progress_bar(self.x.count as u64, "columns");
        let start = Instant::now();
        let effort = Effort { steps: (2 * self.y.count).max(200), ..Effort::default() };
        let found = map(&scene, [self.x.clone(), self.y.clone()], effort, || bar.inc(1))?;
        let wall_s = start.elapsed().as_secs_f64();
        bar.finish_and_clear();
        let mut written = Vec::new();
        if let Some(folder) = folder(self.out.as_deref(), self.json, "out/stability") {
            let base = folder.join(format!("map-{}", self.scene.name()));
            let title = format!("Stability region of {}", self.scene.name());
            written = write(&base, &found.table()?, || draw(&picture::region(&title, &found), &base))?;
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
        if self.json {
            return print_json(&report);
        }
        let mut table = TextTable::new([report.x, "at the lowest", report.y]);
        for Column { x, limit } in report.columns {
            let crossings: Vec<String> = limit.crossings.iter().map(|crossing| format!("{crossing:.5}")).collect();
            let start = if limit.stable_at_start { "stable" } else { "unstable" };
            table.push([format!("{x:.5}"), start.to_owned(), crossings.join(" ")]);
        }
        println!("{table}\n{} spectral radii in {wall_s:.2} s", report.evaluations);
        tell(&report.files);
        Ok(())
    }
}
