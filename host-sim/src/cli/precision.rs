//! `host-sim accuracy precision`: f32 and fixed point against f64.

use clap::Args;
use rayon::prelude::*;

use super::flags::Time;
use super::{Failure, SceneArgs, Ui};
use crate::studies::precision::{columns, measure};
use haptic_sim::scenes;

/// Arguments of `precision`.
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
    /// Measures and prints.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
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
