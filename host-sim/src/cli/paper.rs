//! `host-sim paper`: the cooperation paper's experiments beside its own numbers. The main job of the project.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::flags::Out;
use super::ui::pictures;
use super::{Failure, Ui};
use crate::studies::figures;
use crate::studies::paper::{DURATION_S, experiment_columns, experiments, gain_columns, gains};
use haptic_core::num::Scalar;
use haptic_sim::report::Columns;

/// Arguments of `paper`.
#[derive(Debug, Default, Args)]
pub(super) struct Paper {
    #[command(flatten)]
    out: Out,
}

#[derive(Serialize)]
struct Document {
    experiments: Columns,
    gains: Columns,
    pictures: Vec<PathBuf>,
}

impl Paper {
    /// Runs the experiments and prints the tables.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let bar = ui.progress(3, "experiments, gains, pictures");
        let experiments = experiments().map_err(|error| error.to_string())?;
        bar.inc(1);
        let gains = gain_columns(&gains().map_err(|error| error.to_string())?);
        bar.inc(1);
        let made = ui.made().with("number_type", f64::NAME).with("seconds", DURATION_S).with("scenes", "built in");
        let table = experiment_columns(&experiments);
        let files = ui.files(ui.folder(self.out.folder(), "out/paper").as_deref(), "paper", &made, |files| {
            files.csv(&table)?;
            figures::paper(&experiments).iter().try_for_each(|(name, figure)| files.figure(Some(name), figure))
        })?;
        bar.finish_and_clear();
        let document = Document { experiments: table, gains, pictures: pictures(files) };
        ui.document_of(&made, &document)?;
        writeln!(
            ui,
            "Distributed haptic cooperation (Rakhsha & Constantinescu 2012), section 5: means over 10 s, mm and N\n"
        );
        ui.table(&document.experiments);
        ui.table(&document.experiments.meanings());
        writeln!(ui, "Largest coordination gain at 16 ms round trip\n");
        ui.table(&document.gains);
        if !document.pictures.is_empty() {
            ui.pictures(&document.pictures);
        }
        Ok(())
    }
}
