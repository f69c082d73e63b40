//! `host-sim stability paper`: Figure 4 of the cooperation paper.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use serde::Serialize;

use crate::cli::flags::Out;
use crate::cli::{Failure, Ui};

use haptic_analysis::Column;
use haptic_analysis::figure4::{self, Curve};
use haptic_analysis::picture;
use haptic_core::num::Scalar;
use haptic_sim::report::Columns;

/// Arguments of `stability paper`.
#[derive(Debug, Args)]
pub(in crate::cli) struct Paper {
    #[command(flatten)]
    out: Out,
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
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let points = figure4::COMMS.len() * figure4::DELAYS.len() * figure4::POINTS;
        let bar = ui.progress(points as u64, "Figure 4");
        let start = Instant::now();
        let curves = figure4::curves(|| bar.inc(1))?;
        let wall_s = start.elapsed().as_secs_f64();
        bar.finish_and_clear();
        let made = ui.made().with("number_type", f64::NAME);
        let folder = ui.folder(self.out.folder(), "out/stability");
        let files = ui.files(folder.as_deref(), "figure4", &made, |files| {
            files.csv(&figure4::table(&curves))?;
            files.figure(None, &picture::figure4(&curves))
        })?;
        let evaluations = curves.iter().map(|(_, map)| map.evaluations()).sum();
        let curves = curves.into_iter().map(|(curve, _)| curve).collect();
        let report = PaperReport { curves, evaluations, wall_s, files };
        ui.document_of(&made, &report)?;
        writeln!(ui, "Largest stable K_T (N/m) up to 12000, from 0 upwards, and further crossings\n");
        let near = |curve: &Curve, stiffness: f64| {
            let distance = |column: &Column| (column.x - stiffness).abs();
            let nearest = curve.columns.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
            nearest.map(|column| column.limit.crossings.clone())
        };
        let mut table = Columns::of(&report.curves)
            .value("comm", |curve| curve.comm)
            .value("n_t", |curve| curve.one_way_delay_packets)
            .head("n_t");
        for stiffness in [250.0, 500.0, 1000.0, 1500.0] {
            let head = format!("K_LC {stiffness}");
            table = table.number(head.clone(), 0, |curve| near(curve, stiffness)).head(&head);
        }
        writeln!(ui, "{}\n{evaluations} spectral radii in {wall_s:.2} s", table.done());
        ui.wrote(&report.files);
        Ok(())
    }
}
