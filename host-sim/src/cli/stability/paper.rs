//! `host-sim stability paper`: Figure 4 of the cooperation paper.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use serde::Serialize;

use super::super::ui::save;
use super::super::{Failure, Ui};

use haptic_analysis::figure4::{self, Curve};
use haptic_analysis::picture;
use haptic_plot::draw;
use haptic_sim::report::text::TextTable;

/// Arguments of `stability paper`.
#[derive(Debug, Args)]
pub(super) struct Paper {
    /// Folder for CSV and picture.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Serialize)]
struct PaperReport {
    curves: Vec<Curve>,
    evaluations: usize,
    wall_s: f64,
    files: Vec<PathBuf>,
}

impl Paper {
    /// Answers.
    ///
    /// # Errors
    /// A bad scene, key or range; a file that cannot be written.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let points = figure4::COMMS.len() * figure4::DELAYS.len() * figure4::POINTS;
        let bar = ui.progress(points as u64, "Figure 4");
        let start = Instant::now();
        let curves = figure4::curves(|| bar.inc(1))?;
        let wall_s = start.elapsed().as_secs_f64();
        bar.finish_and_clear();
        let mut written = Vec::new();
        if let Some(folder) = ui.folder(self.out.as_deref(), "out/stability") {
            let base = folder.join("figure4");
            let table = figure4::table(&curves)?;
            written = save(&base, &table, || draw(&picture::figure4(&curves), &base))?;
        }
        let evaluations = curves.iter().map(|(_, map)| map.evaluations()).sum();
        let curves = curves.into_iter().map(|(curve, _)| curve).collect();
        let report = PaperReport { curves, evaluations, wall_s, files: written };
        ui.document(&report)?;
        writeln!(ui, "Largest stable K_T (N/m) up to 12000, from 0 upwards, and further crossings\n");
        let mut table = TextTable::new(["comm", "n_t", "K_LC 250", "500", "1000", "1500"]);
        for Curve { comm, one_way_delay_packets, columns } in &report.curves {
            let near = |stiffness: f64| {
                let nearest = columns.iter().min_by(|a, b| (a.x - stiffness).abs().total_cmp(&(b.x - stiffness).abs()));
                let crossings = nearest.map(|column| column.limit.crossings.as_slice()).unwrap_or_default();
                crossings.iter().map(|crossing| format!("{crossing:.0}")).collect::<Vec<_>>().join(" ")
            };
            let row = [250.0, 500.0, 1000.0, 1500.0].map(near);
            table.push([(*comm).to_owned(), one_way_delay_packets.to_string()].into_iter().chain(row));
        }
        writeln!(ui, "{table}\n{evaluations} spectral radii in {wall_s:.2} s");
        ui.wrote(&report.files);
        Ok(())
    }
}
