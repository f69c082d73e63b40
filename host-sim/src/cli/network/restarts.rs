//! `host-sim network restarts`: peers that start anew at random instants, over the scene's network, in virtual time.

use clap::Args;

use crate::cli::{Failure, SceneArgs, Ui};
use crate::trials::restarts::{PATIENCE_S, run};

/// Arguments of `restarts`.
#[derive(Debug, Args)]
#[command(mut_arg("scene", |scene| scene.default_value("paper-5.2-passive-wave-16ms")))]
pub(in crate::cli) struct Restarts {
    #[command(flatten)]
    scene: SceneArgs,
    /// How many restarts.
    #[arg(long, default_value_t = 10_000, value_name = "N",
        value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    count: u32,
}

impl Restarts {
    /// Runs them and reports.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        let report = run(&scene, u64::from(self.count), scene.world.network.seed.into())?;
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
