//! `host-sim restarts`: peers that start anew at random instants, over the scene's network, in virtual time.

use clap::Args;

use super::{Failure, SceneArgs, Ui};
use crate::trials::restarts::{PATIENCE_S, run};

/// The scene without `--scene`.
const SCENE: &str = "paper-5.2-passive-wave-16ms";

/// Arguments of `restarts`.
#[derive(Debug, Args)]
#[command(mut_arg("scene", |scene| {
    scene.help(format!("Scene file (TOML) or the name of a built-in one [default: {SCENE}]"))
}))]
pub(super) struct Restarts {
    #[command(flatten)]
    scene: SceneArgs,
    /// How many restarts.
    #[arg(long, default_value_t = 10_000, value_name = "N", allow_negative_numbers = true,
        value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    count: u32,
    /// Seed of the instants; the network has its own, network.seed.
    #[arg(long, default_value_t = 1, value_name = "N", allow_negative_numbers = true)]
    seed: u64,
}

impl Restarts {
    /// Runs them and reports.
    ///
    /// # Errors
    /// A bad scene, or a network over which two peers never meet.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let report = run(&self.scene.load_or(SCENE)?, u64::from(self.count), self.seed)?;
        ui.document(&report)?;
        writeln!(
            ui,
            "{} restarts: engaged again after {:.1} ms on average, {:.0} ms at the most; {} were not engaged again within {PATIENCE_S} s",
            report.restarts, report.mean_ms, report.slowest_ms, report.failed
        );
        writeln!(ui, "{} times the peer that stayed did not let go; {} faults", report.held_on, report.faults);
        writeln!(
            ui,
            "motor forces begin at {} N and step by {:.3} N at the most ({} N allowed); coordination begins with {:.3} N",
            report.arming_force_n, report.largest_step_n, report.allowed_step_n, report.first_force_n
        );
        Ok(())
    }
}
