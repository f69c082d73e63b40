//! `host-sim precision`: f32 and fixed point against f64.

use clap::Args;
use rayon::prelude::*;

use super::{Failure, SceneArgs, Ui};
use crate::studies::precision::{columns, measure};
use haptic_sim::scenes;

/// Arguments of `precision`.
#[derive(Debug, Args)]
pub(super) struct Precision {
    #[command(flatten)]
    scene: SceneArgs,
    /// Every built-in scene instead of one.
    #[arg(long, conflicts_with_all = ["scene", "set"])]
    all: bool,
    /// Simulated time, s.
    #[arg(long, default_value_t = 60.0, value_name = "S", allow_negative_numbers = true)]
    duration_s: f64,
}

impl Precision {
    /// Measures and prints.
    ///
    /// # Errors
    /// A bad scene.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        if !(self.duration_s > 0.0 && self.duration_s <= 86_400.0) {
            let message =
                format!("--duration-s {} is not allowed: it must be above 0 and up to 86400 s", self.duration_s);
            return Err(message.into());
        }
        let scenes = if self.all {
            scenes::ALL.iter().map(|(name, _)| Ok(((*name).to_owned(), scenes::load(name)?))).collect()
        } else {
            self.scene.load().map(|scene| vec![(self.scene.name(), scene)])
        }?;
        let rows = scenes
            .par_iter()
            .map(|(name, scene)| measure(name, scene, self.duration_s))
            .collect::<Result<Vec<_>, _>>()?;
        writeln!(ui, "Largest difference from f64 over {} s\n", self.duration_s);
        ui.result(&columns(&rows))
    }
}
