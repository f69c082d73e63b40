//! `host-sim keygen`, `key-image`, `peer`, `relay` and `trace`: two peers as two processes, for real.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::{Failure, SceneArgs, Ui, granted};
use crate::live::endpoint::Stop;
use crate::live::{peer, relay};
use crate::shared::world::host::MOST_LINES;
use haptic_sim::key_file;
use haptic_sim::network::link::Route;
use haptic_sim::network::rule::{Direction, NetworkTrace};

/// Arguments of `keygen`.
#[derive(Debug, Args)]
pub(super) struct Keygen {
    /// File to make; an existing one is left alone.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The key of one line of a server or a hub, made from its key.
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true, requires = "of", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_LINES)))]
    line: Option<u32>,
    /// The server's or hub's key file.
    #[arg(long, value_name = "FILE", requires = "line")]
    of: Option<PathBuf>,
}

impl Keygen {
    /// Makes the file.
    ///
    /// # Errors
    /// It exists, or cannot be written.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let file = self.file.display();
        match (self.line, &self.of) {
            (Some(line), Some(of)) => {
                key_file::write(&self.file, &key_file::read(of)?.line(line))?;
                writeln!(ui, "wrote {file}: for line {line}; copy it there over a way that you trust");
            }
            _ => {
                key_file::generate(&self.file)?;
                writeln!(ui, "wrote {file}: copy it to the other peer over a way that you trust");
            }
        }
        ui.document(&json!({ "files": [&self.file] }))
    }
}

/// Arguments of `key-image`.
#[derive(Debug, Args)]
pub(super) struct KeyImage {
    /// Key file (`host-sim keygen`).
    #[arg(value_name = "FILE")]
    key_file: PathBuf,
    /// File to make, as secret as the key; an existing one is left alone.
    #[arg(value_name = "IMAGE")]
    image: PathBuf,
}

impl KeyImage {
    /// Writes the key as a board keeps it in flash; `cargo xtask provision` puts it there.
    ///
    /// # Errors
    /// No key file, or the image exists or cannot be written.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        key_file::write_secret(&self.image, &key_file::read(&self.key_file)?.image())?;
        ui.document(&json!({ "files": [&self.image] }))
    }
}

/// Arguments of `peer`.
#[derive(Debug, Args)]
pub(super) struct Peer {
    #[command(flatten)]
    scene: SceneArgs,
    /// Which of the two: 1 (left) or 2 (right).
    #[arg(long, allow_negative_numbers = true, value_parser = clap::value_parser!(u8).range(1..=2))]
    number: u8,
    /// Where this peer listens.
    #[arg(long, value_name = "ADDRESS:PORT")]
    listen: SocketAddr,
    /// Where the other peer, or the hub, listens.
    #[arg(long, value_name = "ADDRESS:PORT")]
    connect: SocketAddr,
    /// Key file, the same for both, or that of this peer's line at a hub (`host-sim keygen`).
    #[arg(long, value_name = "FILE")]
    key_file: PathBuf,
    /// Time of the experiment once both are there, s.
    #[arg(long, default_value_t = 20.0, value_name = "S", allow_negative_numbers = true)]
    duration_s: f64,
    /// How long to call before giving up, s.
    #[arg(long, default_value_t = 30.0, value_name = "S", allow_negative_numbers = true)]
    patience_s: f64,
}

/// A time in seconds on the command line.
pub(super) fn check_time(name: &str, value: f64) -> Result<(), Failure> {
    if value > 0.0 && value <= 86_400.0 {
        return Ok(());
    }
    Err(format!("{name} {value} is not allowed: it must be above 0 and up to 86400 s").into())
}

impl Peer {
    /// Runs the peer and reports.
    ///
    /// # Errors
    /// A bad scene, key file or address; nobody answering.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        check_time("--duration-s", self.duration_s)?;
        check_time("--patience-s", self.patience_s)?;
        let scene = self.scene.load()?;
        let key = key_file::read(&self.key_file)?;
        let options = peer::Options {
            number: self.number,
            listen: self.listen,
            connect: self.connect,
            duration_s: self.duration_s,
            patience_s: self.patience_s,
        };
        let report = peer::run(&scene, key, &options, &Stop::on_signals()?)?;
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

/// Arguments of `relay`.
#[derive(Debug, Args)]
pub(super) struct Relay {
    #[command(flatten)]
    scene: SceneArgs,
    /// Where peer 1 sends to.
    #[arg(long, value_name = "ADDRESS:PORT")]
    listen_1: SocketAddr,
    /// Where peer 2 sends to.
    #[arg(long, value_name = "ADDRESS:PORT")]
    listen_2: SocketAddr,
    /// Recorded network (as `--set network.trace=FILE`).
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// How long, s.
    #[arg(long, default_value_t = 60.0, value_name = "S", allow_negative_numbers = true)]
    duration_s: f64,
}

impl Relay {
    /// Relays until the time is over.
    ///
    /// # Errors
    /// A bad scene, trace or address.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        check_time("--duration-s", self.duration_s)?;
        let mut scene = self.scene.load()?;
        if let Some(trace) = &self.trace {
            scene.network_trace = Some(NetworkTrace::read(trace)?.into());
        }
        let routes = [Direction::OneToTwo, Direction::TwoToOne].map(|direction| Route::of_scene(&scene, direction, 0));
        let listen = [self.listen_1, self.listen_2];
        let relayed = relay::run(routes, listen, self.duration_s, &Stop::on_signals()?)?;
        ui.document(&relayed)?;
        for (way, count) in ["1 to 2", "2 to 1"].iter().zip(relayed) {
            writeln!(
                ui,
                "{way}: {} taken, {} sent on, {} lost, {} broken",
                count.taken, count.sent, count.lost, count.corrupt
            );
        }
        Ok(())
    }
}

/// Arguments of `trace`.
#[derive(Debug, Args)]
pub(super) struct Trace {
    #[command(flatten)]
    scene: SceneArgs,
    /// How much of the network to write down, s.
    #[arg(long, default_value_t = 20.0, value_name = "S", allow_negative_numbers = true)]
    duration_s: f64,
    /// CSV file to write.
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

impl Trace {
    /// Writes what the scene's network would do to a file that replays it.
    ///
    /// # Errors
    /// A bad scene, or a file that cannot be written.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        check_time("--duration-s", self.duration_s)?;
        let scene = self.scene.load()?;
        let timing = &scene.peer.timing;
        let packet_s = timing.packet_period_s();
        NetworkTrace::record(&scene, (self.duration_s / packet_s).ceil() as u64).write(&self.file)?;
        writeln!(ui, "wrote {}", self.file.display());
        ui.document(&json!({ "files": [&self.file] }))
    }
}
