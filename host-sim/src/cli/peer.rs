//! `host-sim peer`: one of two peers as a process of its own, for real.

use std::net::SocketAddr;

use clap::Args;

use super::flags::{KeyFile, Patience, Time};
use super::{Failure, SceneArgs, Ui, granted};
use crate::live::endpoint::{Span, Stop};
use crate::live::peer;

/// Arguments of `peer`.
#[derive(Debug, Args)]
pub(super) struct Peer {
    #[command(flatten)]
    scene: SceneArgs,
    /// Which of the two: 1 (left) or 2 (right).
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=2))]
    number: u8,
    /// Where this peer listens.
    #[arg(long, value_name = "ADDRESS:PORT")]
    listen: SocketAddr,
    /// Where the other peer, or the hub, listens.
    #[arg(long, value_name = "ADDRESS:PORT")]
    connect: SocketAddr,
    #[command(flatten)]
    key: KeyFile,
    #[command(flatten)]
    time: Time,
    #[command(flatten)]
    patience: Patience,
}

impl Peer {
    /// Runs the peer and reports.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        let key = self.key.read()?;
        let span = Span { duration_s: self.time.seconds, patience_s: self.patience.patience_s };
        let ends = [self.listen, self.connect];
        let report = peer::run(&scene, key, self.number, ends, span, &Stop::on_signals()?)?;
        ui.document(&report)?;
        writeln!(
            ui,
            "peer {}: decoded discrepancy {:.4} mm, coordination force {:.4} N over the last half",
            report.peer, report.decoded_discrepancy_mm, report.coordination_force_n
        );
        if let Some(fault) = &report.fault {
            writeln!(ui, "stopped with {fault}");
        }
        let kept = report.punctuality;
        writeln!(
            ui,
            "{} ticks armed; {} ticks began more than a period late, the latest by {} us, {:.0} us on average; real-time priority: {}",
            report.ticks,
            kept.missed,
            kept.worst_us,
            kept.mean_us(),
            granted(kept.realtime_priority)
        );
        writeln!(
            ui,
            "round trip {} us, jitter {} us, the other clock {} us ahead and {:.1} ppm faster; datagrams: {} taken, {} missing, {} refused",
            report.round_trip_us.map_or_else(|| "?".to_owned(), |us| us.to_string()),
            report.jitter_us,
            report.clock_offset_us.map_or_else(|| "?".to_owned(), |us| us.to_string()),
            report.clock_drift_ppm,
            report.datagrams_taken,
            report.datagrams_missing,
            report.datagrams_refused
        );
        for (time_s, notice) in &report.notices {
            writeln!(ui, "{time_s:9.3} s  {notice}");
        }
        Ok(())
    }
}
