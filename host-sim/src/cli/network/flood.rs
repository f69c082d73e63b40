//! `host-sim network flood`: forged datagrams against two peers on loopback.

use clap::Args;

use crate::cli::flags::{Time, number};
use crate::cli::{Failure, SceneArgs, Ui};
use crate::live::endpoint::Stop;
use crate::trials::flood::run;
use haptic_sim::report::Columns;

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
        let report = run(&self.scene.load(ui)?, self.rate, self.time.seconds, &Stop::on_signals()?)?;
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
        let peers: Vec<_> = (1..).zip(&report.peers).collect();
        let table = Columns::of(&peers)
            .value("peer", |(peer, _)| *peer)
            .value("forged", |(_, seen)| seen.forged_arrived)
            .value("taken", |(_, seen)| seen.forged_taken)
            .value("states_changed", |(_, seen)| seen.states_changed)
            .value("states_compared", |(_, seen)| seen.states_compared)
            .value("welcomes", |(_, seen)| seen.hellos_answered)
            .value("session_stayed", |(_, seen)| seen.session_stayed)
            .number("flow_through", 1, |(_, seen)| seen.flow_through)
            .shown_in("%", 1e2)
            .value("silence_ms", |(_, seen)| seen.longest_silence_ms)
            .value("whole_after_ms", |(_, seen)| seen.whole_after_ms)
            .done();
        ui.table(&table);
        Ok(())
    }
}
