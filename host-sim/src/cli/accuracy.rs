//! `host-sim accuracy`: speed against error, for every numerical choice; and what each model adds to a scene.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::flags::{Out, choice};
use super::precision::Precision;
use super::ui::pictures;
use super::{Failure, Ui};
use crate::studies::accuracy::counts::{Processor, SCALARS};
use crate::studies::accuracy::{self, Family, cost, picture};

/// Arguments of `accuracy`.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(in crate::cli) struct Accuracy {
    #[command(subcommand)]
    question: Option<Question>,
    /// Whose instructions.
    #[arg(long, default_value = "cortex-m7", value_parser = choice::<Processor>(), value_name = "NAME")]
    processor: Processor,
    #[command(flatten)]
    out: Out,
}

super::commands! {
    /// What else can be asked.
    Question {
        /// How far f32 and fixed point stray from f64, scene by scene.
        Precision(Precision),
    }
}

#[derive(Serialize)]
struct Document {
    /// What instructions are instructions of.
    processor: Processor,
    families: Vec<Family>,
    /// Number types of the columns of `cost_per_scene`.
    scalars: [&'static str; 3],
    cost_per_scene: Vec<cost::Cost>,
    pictures: Vec<PathBuf>,
}

impl Accuracy {
    /// Measures, prints and draws.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        if let Some(question) = &self.question {
            return question.run(ui);
        }
        ui.only_built_in("accuracy compares");
        let bar = ui.progress(2, "errors, pictures");
        let (families, cost_per_scene) = (accuracy::families(self.processor)?, cost::table(self.processor));
        bar.inc(1);
        let made = ui.made().with("instructions_of", self.processor.label());
        let figures = || picture::all(&families, &cost_per_scene, self.processor);
        let folder = ui.folder(self.out.folder(), "out/accuracy");
        let files = ui.files(folder.as_deref(), "accuracy", &made, |files| {
            files.csv(&accuracy::columns(&families, true))?;
            figures().iter().try_for_each(|(name, figure)| files.figure(Some(name), figure))
        })?;
        bar.finish_and_clear();
        let pictures = pictures(files);
        let document = Document { processor: self.processor, families, scalars: SCALARS, cost_per_scene, pictures };
        ui.document_of(&made, &document)?;
        document.print(ui);
        Ok(())
    }
}

impl Document {
    fn print(&self, ui: &Ui) {
        writeln!(ui, "Speed against error; instructions of {}\n", self.processor.label());
        for family in &self.families {
            writeln!(ui, "{}\n\n  {}\n  Against {}.\n", family.title, family.motion, family.reference);
            writeln!(ui, "{}\n{}\n", accuracy::columns([family], false), family.insight);
        }
        writeln!(
            ui,
            "Cost per scene: instructions of one tick, and what the scene adds to the one it is compared with\n"
        );
        ui.table(&cost::columns(&self.cost_per_scene));
        ui.pictures(&self.pictures);
    }
}
