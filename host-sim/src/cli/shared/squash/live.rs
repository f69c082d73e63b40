//! `host-sim shared squash live`: the game in real time over UDP.

use std::net::SocketAddr;

use clap::Args;

use super::Rules;
use crate::cli::flags::{KeyFile, Time};
use crate::cli::{Failure, Ui};
use crate::live::endpoint::Stop;
use crate::live::squash::{self, Options, Report};
use haptic_sim::report::Columns;

/// Arguments of `squash live`.
#[derive(Debug, Args)]
pub(super) struct Live {
    /// Which one: 0 is the server, 1, 2 … the players.
    #[arg(long, value_name = "N")]
    number: u8,
    /// Where each of them listens, in order, the server first; the same for all.
    #[arg(long, value_name = "ADDRESS:PORT,…", value_delimiter = ',', required = true)]
    addresses: Vec<SocketAddr>,
    #[command(flatten)]
    key: KeyFile,
    #[command(flatten)]
    rules: Rules,
}

impl Live {
    /// Plays and reports.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let Rules { bounder, motion_bounder, time: Time { seconds } } = self.rules;
        for (at, address) in self.addresses.iter().enumerate() {
            if self.addresses[..at].contains(address) {
                return Err(format!("--addresses has {address} twice: each of them has one of its own").into());
            }
        }
        let key = self.key.read()?;
        let addresses = self.addresses.clone();
        let options = Options { number: self.number, addresses, bounder, motion_bounder, seconds };
        let report = squash::run(&key, &options, &Stop::on_signals()?)?;
        ui.document(&report)?;
        print(ui, &report);
        Ok(())
    }
}

fn print(ui: &Ui, report: &Report) {
    let table = Columns::of(&report.rallies)
        .value("rally", |rally| rally.rally)
        .value("strokes", |rally| rally.strokes)
        .value("ending", |rally| rally.ending.clone())
        .value("loser", |rally| rally.loser)
        .done();
    ui.table(&table);
    let score = report.score.iter().map(u8::to_string).collect::<Vec<_>>().join(" : ");
    writeln!(ui, "score {score}; {} hits of its own, {} balls seen too late", report.strokes, report.unseen);
    writeln!(
        ui,
        "longest round trip {:.2} ms; {} links up, {} datagrams refused; {} ticks late",
        report.round_trip_ms, report.links, report.refused, report.punctuality.missed
    );
    for other in &report.others {
        writeln!(ui, "{other}");
    }
}
