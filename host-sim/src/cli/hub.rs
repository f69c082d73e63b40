//! `host-sim hub`: where 2 to 16 live peers hold one object.

use std::net::SocketAddr;

use clap::Args;

use super::flags::{KeyFile, Patience, Time};
use super::{Failure, SceneArgs, Ui, granted};
use crate::live::endpoint::Stop;
use crate::live::hub;
use crate::shared::cooperative::MOST_USERS;
use haptic_sim::report::text::{TextTable, significant};

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
        let scene = self.scene.load()?;
        let key = self.key.read()?;
        let options = hub::Options {
            users: self.users.into(),
            listen: self.listen,
            duration_s: self.time.seconds,
            patience_s: self.patience.patience_s,
        };
        ui.status(format_args!("hub for {} peers listens on {}", self.users, self.listen));
        let report = hub::run(&scene, &key, &options, &Stop::on_signals()?)?;
        ui.document(&report)?;
        let mut table = TextTable::new([
            "line",
            "number",
            "from",
            "lives",
            "taken",
            "missing",
            "round trip us",
            "put in J",
            "sent back J",
            "copy mm",
            "F_T N",
        ]);
        let or_dash = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| significant(value, 3));
        for line in &report.lines {
            table.push([
                line.line.to_string(),
                line.number.to_string(),
                line.address.clone().unwrap_or_else(|| "-".to_owned()),
                line.lives.to_string(),
                line.datagrams_taken.to_string(),
                line.datagrams_missing.to_string(),
                line.round_trip_us.map_or_else(|| "-".to_owned(), |us| us.to_string()),
                significant(line.energy.put_in_j, 3),
                significant(line.energy.sent_j, 3),
                or_dash(line.copy_mm),
                or_dash(line.said.map(|said| said.coordination_force_n.into())),
            ]);
        }
        ui.table(&table);
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
