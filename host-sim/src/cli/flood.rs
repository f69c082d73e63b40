//! `host-sim flood`: forged datagrams against two peers on loopback.

use clap::Args;

use super::{Failure, SceneArgs, Ui};
use crate::live::endpoint::Stop;
use crate::trials::flood::{Options, run};
use haptic_sim::report::text::TextTable;

/// Most forged datagrams per second that may be asked for.
const MOST_PER_S: f64 = 1e7;

/// Arguments of `flood`.
#[derive(Debug, Args)]
pub(super) struct Flood {
    #[command(flatten)]
    scene: SceneArgs,
    /// Forged datagrams per second, both peers together.
    #[arg(long, default_value_t = 100_000.0, value_name = "PER_S", allow_negative_numbers = true)]
    rate: f64,
    /// Length of the flood, s.
    #[arg(long, default_value_t = 5.0, value_name = "S", allow_negative_numbers = true)]
    seconds: f64,
}

impl Flood {
    /// Floods and reports.
    ///
    /// # Errors
    /// A bad scene, rate or time.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        if !(self.rate >= 1.0 && self.rate <= MOST_PER_S) {
            return Err(format!("--rate {} is not allowed: it must be from 1 to {MOST_PER_S} per s", self.rate).into());
        }
        super::live::check_time("--seconds", self.seconds)?;
        let options = Options { rate_per_s: self.rate, seconds: self.seconds };
        let report = run(&self.scene.load()?, &options, &Stop::on_signals()?)?;
        ui.document(&report)?;
        writeln!(
            ui,
            "{:.0} forged datagrams per second for {:.2} s ({:.0} asked for); the system dropped {:.1} %",
            report.rate_sent_per_s,
            report.flood_s,
            report.rate_asked_per_s,
            1e2 * report.dropped_by_system
        );
        let kinds: Vec<String> = report.sent.iter().map(|(kind, count)| format!("{count} {kind}")).collect();
        writeln!(ui, "{}", kinds.join(", "));
        let mut table = TextTable::new([
            "peer",
            "forged",
            "taken",
            "states changed",
            "of",
            "welcomes",
            "session",
            "flow through",
            "silence ms",
            "whole after ms",
        ]);
        for (peer, seen) in (1..).zip(&report.peers) {
            table.push([
                format!("{peer}"),
                seen.forged_arrived.to_string(),
                seen.forged_taken.to_string(),
                seen.states_changed.to_string(),
                seen.states_compared.to_string(),
                seen.hellos_answered.to_string(),
                if seen.session_stayed { "stayed" } else { "LOST" }.to_owned(),
                format!("{:.1} %", 1e2 * seen.flow_through),
                seen.longest_silence_ms.to_string(),
                seen.whole_after_ms.to_string(),
            ]);
        }
        ui.table(&table);
        Ok(())
    }
}
