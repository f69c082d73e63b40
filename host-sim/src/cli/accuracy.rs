//! `host-sim accuracy`: speed against error, for every numerical choice; and what each model adds to a scene.

use clap::Args;
use rayon::prelude::*;
use serde_json::json;

use super::flags::{Out, Time, choice};
use super::{Failure, SceneArgs, Ui, ui::pictures};
use crate::studies::accuracy::counts::{Processor, SCALARS, cost_columns, costs};
use crate::studies::accuracy::{self, picture};
use crate::studies::precision::{columns, measure};
use haptic_sim::scenes;

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
    Question {
        /// How far f32 and fixed point stray from f64, scene by scene.
        Precision(Precision),
    }
}

impl Accuracy {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        if let Some(question) = &self.question {
            return question.run(ui);
        }
        ui.only_built_in("accuracy compares");
        let ((families, cost_per_scene), _) =
            ui.work(1, "errors", |_| Ok::<_, Failure>((accuracy::families(self.processor)?, costs(self.processor))))?;
        let made = ui.made().with("instructions_of", self.processor.label());
        let files = ui.files(&self.out, "accuracy", "accuracy", &made, |files| {
            files.csv(&accuracy::columns(&families, true))?;
            let figures = picture::all(&families, &cost_per_scene, self.processor);
            figures.iter().try_for_each(|(name, figure)| files.figure(Some(name), figure))
        })?;
        let pictures = pictures(files);
        ui.document_of(
            &made,
            &json!({
                "processor": self.processor, "families": families, "scalars": SCALARS,
                "cost_per_scene": cost_per_scene, "pictures": pictures,
            }),
        )?;
        writeln!(ui, "Speed against error; instructions of {}\n", self.processor.label());
        for family in &families {
            writeln!(ui, "{}\n\n  {}\n  Against {}.\n", family.title, family.motion, family.reference);
            writeln!(ui, "{}\n{}\n", accuracy::columns([family], false), family.insight);
        }
        writeln!(
            ui,
            "Cost per scene: instructions of one tick, and what the scene adds to the one it is compared with\n"
        );
        ui.table(&cost_columns(&cost_per_scene));
        ui.pictures(&pictures);
        Ok(())
    }
}

#[derive(Debug, Args)]
#[command(mut_arg("seconds", |arg| arg.default_value("60")))]
pub(in crate::cli) struct Precision {
    #[command(flatten)]
    scene: SceneArgs,
    /// Every built-in scene instead of one.
    #[arg(long, conflicts_with_all = ["scene", "set"])]
    all: bool,
    #[command(flatten)]
    time: Time,
}

impl Precision {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scenes = if self.all {
            scenes::ALL.iter().map(|(name, _)| Ok(((*name).to_owned(), scenes::load(ui.laws, name)?))).collect()
        } else {
            self.scene.load(ui).map(|scene| vec![(self.scene.name(), scene)])
        }?;
        let rows = scenes
            .par_iter()
            .map(|(name, scene)| measure(name, scene, self.time.seconds))
            .collect::<Result<Vec<_>, _>>()?;
        writeln!(ui, "Largest difference from f64 over {} s\n", self.time.seconds);
        ui.result(&columns(&rows))
    }
}
