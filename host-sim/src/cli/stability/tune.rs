//! `host-sim stability tune`: gains for a scene, proved and tried out.

use clap::Args;
use haptic_core::num::Scalar;
use serde::Serialize;

use crate::cli::{Failure, SceneArgs, Ui};
use haptic_analysis::tune::{self, BEYOND, Proposal};
use haptic_sim::report::{Cell, Columns, significant};

/// Simulated time that a proposal is tried for, s: eight of the paper's pulses.
const TRIAL_S: f64 = 20.0;

/// Arguments of `stability tune`.
#[derive(Debug, Args)]
pub(in crate::cli) struct Tune {
    #[command(flatten)]
    scene: SceneArgs,
    /// How much either gain, or both, may be raised before anything is unstable: 0.2 is 20 %.
    #[arg(long, default_value_t = 0.2, value_name = "M")]
    margin: f64,
}

/// A proposal that ran.
#[derive(Serialize)]
struct Trial {
    scalar: &'static str,
    duration_s: f64,
    bounded: bool,
    fault: Option<String>,
    true_discrepancy_mm: f64,
    decoded_discrepancy_mm: f64,
    peak_coordination_force_n: f64,
}

#[derive(Serialize)]
struct Report {
    /// Absent where not even the softest contact is stable.
    proposal: Option<Proposal>,
    /// What to add to the command line.
    set: Option<String>,
    trial: Option<Trial>,
}

impl Tune {
    /// Proposes, tries out, reports.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        let bar = ui.progress(tune::steps(), "contact stiffnesses");
        let proposal = tune::tune(&scene, self.margin, || bar.inc(1))?;
        bar.finish_and_clear();
        // In f32: what flies.
        let trial = proposal.map(|proposal| tune::try_out::<f32>(&scene, &proposal, TRIAL_S)).transpose()?;
        let trial = trial.map(|outcome| Trial {
            scalar: f32::NAME,
            duration_s: TRIAL_S,
            bounded: outcome.bounded,
            fault: outcome.fault.map(|(peer, fault)| format!("peer {peer}: {}", fault.explain())),
            true_discrepancy_mm: outcome.true_discrepancy_mm,
            decoded_discrepancy_mm: outcome.decoded_discrepancy_mm,
            peak_coordination_force_n: outcome.peak_coordination_force_n,
        });
        let set = proposal.map(|proposal| proposal.overrides().map(|set| format!("--set {set}")).join(" "));
        let report = Report { proposal, set, trial };
        ui.document_of(&ui.made().settings(scene.settings()), &report)?;
        report.print(ui, &self.scene.name());
        Ok(())
    }
}

impl Report {
    fn print(&self, ui: &Ui, name: &str) {
        let (Some(proposal), Some(set), Some(trial)) = (&self.proposal, &self.set, &self.trial) else {
            writeln!(ui, "{name}: not even the softest contact is stable; try more damping or less delay");
            return;
        };
        let limit =
            |limit: Option<f64>| limit.map_or_else(|| Cell::from(format!("none up to {BEYOND} times")), Cell::from);
        let gains = [
            ("K_LC (N/m)", proposal.contact_stiffness_n_per_m, proposal.contact_limit_n_per_m),
            ("K_T (N/m)", proposal.coordination_stiffness_n_per_m, proposal.coordination_limit_n_per_m),
        ];
        let table = Columns::of(&gains)
            .value("", |gain| gain.0)
            .value("proposal", |gain| gain.1)
            .significant("limit", 4, |gain| limit(gain.2))
            .head("limit with the other as proposed")
            .done();
        let percent = 100.0 * proposal.margin;
        let (radius, raised) = (proposal.spectral_radius, proposal.raised_spectral_radius);
        ui.table(&table);
        writeln!(ui, "Every pair of gains from 0 to {percent:.0} % above the proposal is stable.");
        writeln!(ui, "Spectral radius {radius:.6}; with either gain or both raised by {percent:.0} %, {raised:.6}.");
        let yields = significant(proposal.compliance_mm_per_n, 3);
        writeln!(ui, "Through both contacts and the coordination one hand yields {yields} mm/N to the other.");
        let outcome = match (&trial.fault, trial.bounded) {
            (Some(fault), _) => format!("stopped, {fault}"),
            (None, true) => "settled".to_owned(),
            (None, false) => "grew".to_owned(),
        };
        writeln!(
            ui,
            "Tried for {} s in {}: {outcome}; discrepancy true {} mm, decoded {} mm; peak coordination force {} N.",
            trial.duration_s,
            trial.scalar,
            significant(trial.true_discrepancy_mm, 3),
            significant(trial.decoded_discrepancy_mm, 3),
            significant(trial.peak_coordination_force_n, 3)
        );
        writeln!(ui, "\n    {set}");
    }
}
