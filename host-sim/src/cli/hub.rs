//! `host-sim hub`: where 2 to 16 live peers hold one object.

use std::net::SocketAddr;

use clap::Args;

use super::flags::{KeyFile, Patience, Time};
use super::{Failure, SceneArgs, Ui, granted};
use crate::live::endpoint::{Span, Stop};
use crate::live::hub;
use crate::shared::cooperative::MOST_USERS;
use haptic_sim::report::Columns;

/// Arguments of `hub`.
#[derive(Debug, Args)]
#[command(mut_arg("scene", |scene| scene.default_value("any-network")))]
pub(super) struct Hub {
    #[command(flatten)]
    scene: SceneArgs,
    /// Where the hub listens.
    #[arg(long, value_name = "ADDRESS:PORT")]
    listen: SocketAddr,
    /// How many peers; the one on line n has its key by `key generate --line n --of`, and is number 1 where n is odd, 2 where even.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(2..=MOST_USERS as i64))]
    users: u8,
    #[command(flatten)]
    key: KeyFile,
    #[command(flatten)]
    time: Time,
    #[command(flatten)]
    patience: Patience,
}

impl Hub {
    /// Runs the hub until the time is over, and reports.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        let key = self.key.read()?;
        let span = Span { duration_s: self.time.seconds, patience_s: self.patience.patience_s };
        ui.status(format_args!("hub for {} peers listens on {}", self.users, self.listen));
        let report = hub::run(&scene, &key, self.users.into(), self.listen, span, &Stop::on_signals()?)?;
        ui.document(&report)?;
        let lines = Columns::of(&report.lines)
            .value("line", |line| line.line)
            .value("number", |line| line.number)
            .value("from", |line| line.address.clone())
            .value("lives", |line| line.lives)
            .value("taken", |line| line.datagrams_taken)
            .value("missing", |line| line.datagrams_missing)
            .value("round_trip_us", |line| line.round_trip_us)
            .significant("put_in_j", 3, |line| line.energy.put_in_j)
            .significant("sent_back_j", 3, |line| line.energy.sent_j)
            .significant("copy_mm", 3, |line| line.copy_mm)
            .significant("coordination_force_n", 3, |line| line.said.map(|said| said.coordination_force_n))
            .head("F_T")
            .done();
        ui.table(&lines);
        writeln!(
            ui,
            "{} packet periods; energy out/in {:.6}; the object went {:.2} mm, the copies are {:.2} mm apart as they last said",
            report.packets, report.energy_out_over_in, report.object_mm, report.apart_mm
        );
        let kept = report.punctuality;
        writeln!(
            ui,
            "{} datagrams refused; {} of {} ticks began more than a period late; real-time priority: {}",
            report.datagrams_refused,
            kept.missed,
            kept.ticks,
            granted(kept.realtime_priority)
        );
        Ok(())
    }
}
