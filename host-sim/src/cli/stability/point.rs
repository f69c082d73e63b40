//! `host-sim stability point`: the verdict on one scene.

use clap::Args;
use serde::Serialize;

use crate::cli::{Failure, SceneArgs, Ui};
use haptic_analysis::{Agreement, agreement};
use haptic_analysis::{Verdict, advice, verdict};
use haptic_sim::report::{Cell, Columns};

/// Arguments of `stability point`.
#[derive(Debug, Args)]
pub(in crate::cli) struct Point {
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
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        let report = PointReport {
            verdict: verdict(&scene)?,
            constructions: agreement(&scene.linear())?,
            advice: advice(&scene)?,
        };
        ui.document_of(&ui.made().settings(scene.settings()), &report)?;
        let second = |report: &PointReport| match report.constructions {
            Some(Agreement { matrix, spectral_radius }) => Cell::Number(matrix.max(spectral_radius)),
            None => "none: it has no equations for one of this scene's models".into(),
        };
        let table = Columns::of(std::slice::from_ref(&report))
            .value("stable", |report| report.verdict.stable)
            .number("spectral_radius", 9, |report| report.verdict.spectral_radius)
            .value("states", |report| report.verdict.states)
            .value("rest_modes_left_out", |report| report.verdict.rest_modes)
            .value("taken_apart_into_sum_and_difference", |report| report.verdict.symmetric)
            .power("second_construction_differs_by", 1, second)
            .done();
        writeln!(ui, "{}\n{}", table.down(&[&self.scene.name()]), report.advice);
        Ok(())
    }
}
