//! `host-sim network flood`: forged datagrams against two peers on loopback.

use clap::Args;

use crate::cli::flags::{Time, number};
use crate::cli::{Failure, SceneArgs, Ui};
use crate::live::endpoint::Stop;
use crate::trials::flood::{Options, run};
use haptic_sim::report::text::TextTable;

/// Arguments of `flood`.
#[derive(Debug, Args)]
#[command(mut_arg("seconds", |arg| arg.default_value("5")))]
pub(in crate::cli) struct Flood {
    #[command(flatten)]
    scene: SceneArgs,
    /// Forged datagrams per second, both peers together.
    #[arg(long, default_value = "100000", value_name = "PER_S", value_parser = number(1.0..=1e7, "per s"))]
    rate: f64,
    #[command(flatten)]
    time: Time,
}

impl Flood {
    /// Floods and reports.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let options = Options { rate_per_s: self.rate, seconds: self.time.seconds };
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
