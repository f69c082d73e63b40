//! `host-sim paper`: the cooperation paper's experiments beside its own numbers. The main job of the project.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::{Failure, Ui};
use crate::studies::figures;
use crate::studies::paper::{Experiment, Gain, experiments, gains};
use haptic_sim::report::text::TextTable;

/// Arguments of `paper`.
#[derive(Debug, Default, Args)]
pub(super) struct Paper {
    /// Folder for the pictures.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Serialize)]
struct Document {
    experiments: Vec<Experiment>,
    gains: Vec<Gain>,
    pictures: Vec<PathBuf>,
}

impl Paper {
    /// Runs the experiments and prints the tables.
    ///
    /// # Errors
    /// A picture that cannot be written.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let bar = ui.progress(3, "experiments, gains, pictures");
        let experiments = experiments().map_err(|error| error.to_string())?;
        bar.inc(1);
        let gains = gains().map_err(|error| error.to_string())?;
        bar.inc(1);
        let folder = ui.folder(self.out.as_deref(), "out/paper");
        let pictures = folder.map_or(Ok(Vec::new()), |folder| figures::paper(&experiments, &folder))?;
        bar.finish_and_clear();
        let document = Document { experiments, gains, pictures };
        ui.document(&document)?;
        document.print(ui);
        Ok(())
    }
}

impl Document {
    fn print(&self, ui: &Ui) {
        let dash = || "-".to_owned();
        writeln!(
            ui,
            "Distributed haptic cooperation (Rakhsha & Constantinescu 2012), section 5: means over 10 s, mm and N\n"
        );
        let mut table = TextTable::new([
            "experiment",
            "comm",
            "round trip ms",
            "K_T N/m",
            "stable",
            "decoded mm",
            "paper mm",
            "true mm",
            "true mm/N",
            "F_T N",
            "sd N",
            "object kg",
        ]);
        for one in &self.experiments {
            let force = one.coordination_force_n;
            let when = |number: String| if one.stable { number } else { dash() };
            table.push([
                one.section.clone(),
                one.comm.clone(),
                format!("{:.0}", one.round_trip_ms),
                format!("{:.0}", one.coordination_stiffness_n_per_m),
                if one.stable { "yes" } else { "NO" }.to_owned(),
                when(format!("{:.4}", one.decoded_discrepancy_mm)),
                one.paper_discrepancy_mm.map_or_else(dash, |mm| mm.to_string()),
                when(format!("{:.4}", one.true_discrepancy_mm)),
                when(format!("{:.3}", one.true_discrepancy_mm_per_n)),
                when(format!("{:.3}", force.mean)),
                when(format!("{:.3}", force.sd)),
                one.apparent_object_mass_kg.map_or_else(dash, |mass| format!("{mass:.3}")),
            ]);
        }
        ui.table(&table);
        writeln!(
            ui,
            "decoded: |x_o - x_d| at peer 2, what the paper plots. true: |x_o1 - x_o2| at one instant.\n\
             object: apparent mass of the shared object, copies and line together.\n"
        );
        writeln!(ui, "Largest coordination gain at 16 ms round trip\n");
        let mut table = TextTable::new(["comm", "paper's experiment N/m", "this model's boundaries N/m"]);
        for gain in &self.gains {
            let crossings: Vec<String> = gain.crossings_n_per_m.iter().map(|at| format!("{at:.0}")).collect();
            table.push([gain.comm.clone(), format!("{:.0}", gain.paper_n_per_m), crossings.join(", ")]);
        }
        ui.table(&table);
        let pictures: Vec<_> =
            self.pictures.iter().filter(|path| path.extension().is_some_and(|e| e == "svg")).collect();
        if !pictures.is_empty() {
            writeln!(ui, "Pictures (SVG, and PNG beside each):");
            for picture in pictures {
                writeln!(ui, "  {}", picture.display());
            }
        }
    }
}
