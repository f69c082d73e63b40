//! `cohold paper`: the cooperation paper's experiments beside its own numbers. The main job of the project.

use clap::Args;
use cohold_core::num::Scalar;
use cohold_studies::figures;
use cohold_studies::reproduce::paper::{DURATION_S, experiment_columns, experiments, gain_columns, gains};
use serde_json::json;

use super::reproduce::Reproduce;
use super::{Failure, Ui, flags::Out, ui::pictures};

super::commands! {
    /// Beyond the experiments of the cooperation paper.
    pub(crate) PaperCommands {
        /// Every table and figure of both papers, with a verdict on each claim: matched, holds in part, not matched, circular, not testable.
        Reproduce(Reproduce),
    }
}

#[derive(Debug, Default, Args)]
pub(super) struct Paper {
    #[command(flatten)]
    out: Out,
}

impl Paper {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let ((experiments, gains), _) = ui.work(2, "experiments, gains", |step| {
            let experiments = experiments()?;
            step();
            Ok::<_, Failure>((experiments, gain_columns(&gains()?)))
        })?;
        let provenance =
            ui.provenance().with("number_type", f64::NAME).with("seconds", DURATION_S).with("scenes", "built in");
        let table = experiment_columns(&experiments);
        let files = ui.files(&self.out, "paper", "paper", &provenance, |files| {
            files.csv(&table)?;
            figures::paper(&experiments).iter().try_for_each(|(name, figure)| files.figure(Some(name), figure))
        })?;
        let pictures = pictures(files);
        ui.document_of(&provenance, &json!({ "experiments": table, "gains": gains, "pictures": pictures }))?;
        writeln!(
            ui,
            "Distributed haptic cooperation (Rakhsha & Constantinescu 2012), section 5: means over 10 s, mm and N\n"
        );
        ui.table(&table);
        ui.table(&table.meanings(&["decoded_discrepancy_mm", "true_discrepancy_mm", "apparent_object_mass_kg"]));
        writeln!(ui, "Largest coordination gain at 16 ms round trip\n");
        ui.table(&gains);
        if !pictures.is_empty() {
            ui.pictures(&pictures);
        }
        writeln!(ui, "Next: `cohold play` to hold the object yourself, and docs/start.md for the first ten minutes.");
        Ok(())
    }
}
