//! `host-sim squash`: Force Feedback Multi-player Squash, played by bots.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand, ValueEnum};
use serde::Serialize;

use super::live::nobody;
use super::{Failure, SceneArgs, print_json};
use crate::live::{court, key_file};
use crate::report::text::{TextTable, significant};
use crate::squash::sweep::{Cell, sweep};
use crate::squash::{Options, Report, picture, play};

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Switch {
    /// Bounded by the round trip.
    On,
    /// Not bounded.
    Off,
}

/// Arguments of `squash`.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(super) struct Squash {
    #[command(subcommand)]
    live: Option<Live>,
    #[command(flatten)]
    scene: SceneArgs,
    /// Players.
    #[arg(long, default_value_t = 4, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u8).range(2..=8))]
    players: u8,
    /// Round trip between any two, ms; what the scene's network does comes on top.
    #[arg(long, default_value_t = 100.0, value_name = "R", allow_negative_numbers = true)]
    rtt_ms: f64,
    /// Bounds the speed of the ball.
    #[arg(long, value_enum, default_value = "on")]
    bounder: Switch,
    /// Damps the hands of the players.
    #[arg(long, value_enum, default_value = "on")]
    motion_bounder: Switch,
    /// Simulated time, s.
    #[arg(long, default_value_t = 60.0, value_name = "S", allow_negative_numbers = true)]
    seconds: f64,
    /// Of everything random.
    #[arg(long, default_value_t = 1, value_name = "K", allow_negative_numbers = true)]
    seed: u64,
    /// Round trips of 10 to 400 ms without a bound, with the ball's and with both, instead of one game.
    #[arg(long, conflicts_with_all = ["rtt_ms", "bounder", "motion_bounder"])]
    sweep: bool,
    /// Print JSON; files are written only with --out.
    #[arg(long)]
    json: bool,
    /// Folder for pictures.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
enum Live {
    /// The game in real time over UDP, sealed: this process is its server or one of its players.
    Live(LiveArgs),
}

#[derive(Debug, Args)]
struct LiveArgs {
    /// Which one: 0 is the server, 1, 2 … the players.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    number: u8,
    /// Where each of them listens, in order, the server first; the same for all.
    #[arg(long, value_name = "ADDRESS:PORT,…", value_delimiter = ',', required = true)]
    addresses: Vec<SocketAddr>,
    /// Key file, the same for all (`host-sim keygen`).
    #[arg(long, value_name = "FILE")]
    key_file: PathBuf,
    /// Bounds the speed of the ball; the server's word.
    #[arg(long, value_enum, default_value = "on")]
    bounder: Switch,
    /// Damps this player's hand.
    #[arg(long, value_enum, default_value = "on")]
    motion_bounder: Switch,
    /// How long, s.
    #[arg(long, default_value_t = 60.0, value_name = "S", allow_negative_numbers = true)]
    seconds: f64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

impl LiveArgs {
    fn run(&self) -> Result<(), Failure> {
        check("--seconds", self.seconds, 0.001, 86_400.0, "s")?;
        for (at, address) in self.addresses.iter().enumerate() {
            if self.addresses[..at].contains(address) {
                return Err(format!("--addresses has {address} twice: each of them has one of its own").into());
            }
        }
        let key = key_file::read(&self.key_file)?;
        let report = court::run(
            &key,
            &court::Options {
                number: self.number,
                addresses: self.addresses.clone(),
                bounder: self.bounder == Switch::On,
                motion_bounder: self.motion_bounder == Switch::On,
                seconds: self.seconds,
            },
        )?;
        // Links end with those who leave first; what was played with them, or the round trip, stays.
        if report.links == 0 && report.rallies.is_empty() && report.strokes == 0 && report.round_trip_ms == 0.0 {
            let others = self.addresses.iter().enumerate().filter(|(at, _)| *at != usize::from(self.number));
            return Err(nobody(others.map(|(_, address)| address)).into());
        }
        if self.json {
            return print_json(&report);
        }
        let mut table = TextTable::new(["rally", "strokes", "ending", "loser"]);
        for rally in &report.rallies {
            let numbers = [rally.rally.to_string(), rally.strokes.to_string(), rally.ending.clone()];
            table.push(numbers.into_iter().chain([rally.loser.to_string()]));
        }
        println!("{table}");
        let score = report.score.iter().map(u8::to_string).collect::<Vec<_>>().join(" : ");
        println!("score {score}; {} hits of its own, {} balls seen too late", report.strokes, report.unseen);
        println!(
            "longest round trip {:.2} ms; {} links up, {} datagrams refused; {} beats late",
            report.round_trip_ms, report.links, report.refused, report.punctuality.missed
        );
        Ok(())
    }
}

#[derive(Serialize)]
struct Document {
    players: u8,
    rtt_ms: f64,
    bounder: bool,
    motion_bounder: bool,
    seconds: f64,
    seed: u64,
    #[serde(flatten)]
    report: Report,
    files: Vec<PathBuf>,
}

/// A number on the command line.
fn check(name: &str, value: f64, least: f64, most: f64, unit: &str) -> Result<(), Failure> {
    if value >= least && value <= most {
        return Ok(());
    }
    Err(format!("{name} {value} is not allowed: it must be a number from {least} to {most} {unit}").into())
}

impl Squash {
    /// Plays and reports.
    ///
    /// # Errors
    /// A bad scene or number, or a picture that cannot be written.
    pub(super) fn run(&self) -> Result<(), Failure> {
        if let Some(Live::Live(live)) = &self.live {
            return live.run();
        }
        check("--rtt-ms", self.rtt_ms, 0.0, 2000.0, "ms")?;
        check("--seconds", self.seconds, 0.001, 86_400.0, "s")?;
        let mut options = Options {
            players: self.players,
            round_trip_s: self.rtt_ms * 1e-3,
            network: self.scene.load()?.world.network,
            bounder: self.bounder == Switch::On,
            motion_bounder: self.motion_bounder == Switch::On,
            seconds: self.seconds,
            seed: self.seed,
            changes: Vec::new(),
            record_every: 0,
        };
        if self.sweep {
            let cells = sweep(&options);
            if self.json {
                return print_json(&cells);
            }
            print_sweep(&cells);
            return Ok(());
        }
        let folder = match (&self.out, self.json) {
            (None, true) => None,
            (out, _) => Some(out.as_deref().unwrap_or(Path::new("out/squash"))),
        };
        options.record_every = if folder.is_some() { 5 } else { 0 };
        let game = play(&options);
        let files = match folder {
            Some(folder) => picture::draw_game(&game, &options, &folder.join("squash"))?,
            None => Vec::new(),
        };
        let document = Document {
            players: options.players,
            rtt_ms: self.rtt_ms,
            bounder: options.bounder,
            motion_bounder: options.motion_bounder,
            seconds: self.seconds,
            seed: self.seed,
            report: game.report,
            files,
        };
        if self.json {
            return print_json(&document);
        }
        document.print();
        Ok(())
    }
}

fn yes(flag: bool) -> String {
    if flag { "yes" } else { "NO" }.to_owned()
}

fn print_sweep(cells: &[Cell]) {
    let mut table = TextTable::new([
        "round trip ms",
        "bounder",
        "rallies",
        "strokes",
        "left the court",
        "agreed",
        "fastest m/s",
        "flown before news m",
        "correction m",
        "hand in a round trip m",
    ]);
    for Cell { round_trip_ms, bounder, report } in cells {
        table.push([
            format!("{round_trip_ms:.0}"),
            (*bounder).to_owned(),
            report.rallies.to_string(),
            report.strokes.to_string(),
            report.left_the_court.to_string(),
            yes(report.agreed),
            format!("{:.1}", report.fastest_m_per_s),
            format!("{:.2}", report.farthest_before_news_m),
            format!("{:.2}", report.largest_correction_m),
            format!("{:.2}", report.hand_travel_m),
        ]);
    }
    println!("{table}");
}

impl Document {
    fn print(&self) {
        let report = &self.report;
        let mut table = TextTable::new(["", "squash"]);
        let mut line = |name: &str, value: String| table.push([name.to_owned(), value]);
        line("rallies, strokes, longest", format!("{}, {}, {}", report.rallies, report.strokes, report.longest_rally));
        line("lost, played again", format!("{}, {}", report.lost, report.unseen + report.broken));
        line("score", report.score.iter().map(u8::to_string).collect::<Vec<_>>().join(" : "));
        line("ball left the court before the next player knew", report.left_the_court.to_string());
        line("all agree on every rally and the score", yes(report.agreed));
        if let Some(what) = &report.disagreement {
            line("first disagreement", what.clone());
        }
        line("longest round trip, by the server", format!("{:.1} ms", report.round_trip_ms));
        line("fastest ball, hits made softer", format!("{:.1} m/s, {}", report.fastest_m_per_s, report.bounded));
        line("farthest flight before the next player knew", format!("{:.2} m", report.farthest_before_news_m));
        line("largest correction of a reckoned ball", format!("{:.2} m", report.largest_correction_m));
        line("farthest move of a hand in a round trip", format!("{:.2} m", report.hand_travel_m));
        line("largest error of a hand at another player", format!("{:.2} m", report.hand_error_m));
        line("largest pulse on a device", format!("{} N", significant(report.largest_pulse_n, 3)));
        line("sent by a player", format!("{:.0} bytes/s", report.bytes_per_s));
        line("state hash", report.state_hash.clone());
        println!("{table}");
        for file in &self.files {
            println!("wrote {}", file.display());
        }
    }
}
