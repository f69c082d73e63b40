//! `host-sim stability point`: the verdict on one scene.

use clap::Args;
use serde::Serialize;

use super::super::{Failure, SceneArgs, Ui};
use haptic_analysis::{Agreement, agreement};
use haptic_analysis::{Verdict, advice, verdict};
use haptic_sim::report::text::TextTable;

/// Arguments of `stability point`.
#[derive(Debug, Args)]
pub(super) struct Point {
    #[command(flatten)]
    scene: SceneArgs,
}

#[derive(Serialize)]
struct PointReport {
    #[serde(flatten)]
    verdict: Verdict,
    /// How far apart the two constructions of the lifted matrix are; null where there is only one.
    constructions: Option<Agreement>,
    advice: String,
}

impl Point {
    /// Answers.
    ///
    /// # Errors
    /// A bad scene, key or range; a file that cannot be written.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load()?;
        let report = PointReport {
            verdict: verdict(&scene)?,
            constructions: agreement(&scene.linear())?,
            advice: advice(&scene)?,
        };
        ui.document(&report)?;
        let Verdict { spectral_radius, stable, states, rest_modes, symmetric } = report.verdict;
        let mut table = TextTable::new(["", &self.scene.name()]);
        table.push(["stable", if stable { "yes" } else { "no" }]);
        table.push(["spectral radius".to_owned(), format!("{spectral_radius:.9}")]);
        table.push(["states".to_owned(), states.to_string()]);
        table.push(["rest modes left out".to_owned(), rest_modes.to_string()]);
        table.push(["taken apart into sum and difference", if symmetric { "yes" } else { "no" }]);
        let second = match report.constructions {
            Some(Agreement { matrix, spectral_radius }) => format!("{:.1e}", matrix.max(spectral_radius)),
            None => "none: it has no equations for one of this scene's models".to_owned(),
        };
        table.push(["second construction differs by".to_owned(), second]);
        writeln!(ui, "{table}\n{}", report.advice);
        Ok(())
    }
}
