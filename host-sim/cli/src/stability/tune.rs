//! `cohold stability tune`: gains for a scene, proved and tried out.

use clap::Args;
use cohold_analysis::tune::{self, BEYOND};
use cohold_core::num::Scalar;
use serde_json::json;

use crate::{Failure, SceneArgs, Ui};

/// Simulated time that a proposal is tried for, s: eight of the paper's pulses.
const TRIAL_S: f64 = 20.0;

#[derive(Debug, Args)]
pub(crate) struct Tune {
    #[command(flatten)]
    scene: SceneArgs,
    /// How much either gain, or both, may be raised before anything is unstable: 0.2 is 20 %.
    #[arg(long, default_value_t = 0.2, value_name = "M")]
    margin: f64,
}

impl Tune {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        let steps = tune::steps() as usize;
        let (proposal, _) = ui.work(steps, "contact stiffnesses", |step| tune::tune(&scene, self.margin, step))?;
        // In f32: what flies.
        let trial = proposal.map(|proposal| tune::try_out::<f32>(&scene, &proposal, TRIAL_S)).transpose()?;
        let released = proposal.map(|proposal| tune::let_go::<f32>(&scene, &proposal, TRIAL_S)).transpose()?;
        let trial = trial.map(|outcome| {
            json!({
                "scalar": f32::NAME, "duration_s": TRIAL_S, "bounded": outcome.bounded,
                "reason": outcome.reason.map(|reason| reason.to_string()),
                "fault": outcome.fault.map(|(peer, fault)| format!("peer {peer}: {}", fault.explain())),
                "true_discrepancy_mm": outcome.metric(|o| o.whole.true_discrepancy_mm),
                "decoded_discrepancy_mm": outcome.metric(|o| o.whole.decoded_discrepancy_mm),
                "peak_coordination_force_n": outcome.metric(|o| o.whole.peak_coordination_force_n),
                "released": released,
            })
        });
        // What to add to the command line.
        let set = proposal.map(|proposal| format!("--set {}", proposal.overrides().join(" --set ")));
        if proposal.is_none() {
            writeln!(ui, "not even the softest contact is stable; try more damping or less delay");
        }
        let report = json!({ "proposal": proposal, "set": set, "trial": trial });
        ui.report_of(&ui.provenance().settings(scene.settings()), &self.scene.name(), &report)?;
        let percent = 100.0 * self.margin;
        writeln!(
            ui,
            "With both hands on, one, none, every pair of gains from 0 to {percent:.0} % above the proposal is stable; a limit is one"
        );
        writeln!(ui, "gain's with the other as proposed, none where there is none up to {BEYOND} times.");
        Ok(())
    }
}
