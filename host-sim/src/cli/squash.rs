//! `host-sim squash`: Force Feedback Multi-player Squash, played by bots.

mod live;

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use haptic_protocol::roles::squash::RALLIES;
use serde::Serialize;

use super::{Failure, SceneArgs, Ui};
use crate::shared::squash::sweep::{Cell, sweep};
use crate::shared::squash::{Options, Report, picture, play};
use haptic_sim::report::text::{TextTable, significant};

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Switch {
    /// Bounded by the round trip.
    On,
    /// Not bounded.
    Off,
}

/// What a game goes by, simulated or live.
#[derive(Clone, Copy, Debug, Args)]
struct Rules {
    /// Bounds the speed of the ball; live, the server's word.
    #[arg(long, value_enum, default_value = "on")]
    bounder: Switch,
    /// Damps the hands of the players; live, of this one.
    #[arg(long, value_enum, default_value = "on")]
    motion_bounder: Switch,
    /// How long, s.
    #[arg(long, default_value_t = 60.0, value_name = "S", allow_negative_numbers = true)]
    seconds: f64,
}

impl Rules {
    /// Whether the ball is bounded, whether the hands are, and how long the game is, s.
    ///
    /// # Errors
    /// A time out of range.
    fn read(&self) -> Result<(bool, bool, f64), Failure> {
        check("--seconds", self.seconds, 0.001, 86_400.0, "s")?;
        Ok((self.bounder == Switch::On, self.motion_bounder == Switch::On, self.seconds))
    }
}

/// Arguments of `squash`.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(super) struct Squash {
    #[command(subcommand)]
    question: Option<Question>,
    #[command(flatten)]
    scene: SceneArgs,
    /// Players.
    #[arg(long, default_value_t = 4, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u8).range(2..=8))]
    players: u8,
    /// Round trip between any two, ms, instead of the scene's network.one_way_delay_packets; what else its network does to
    /// packets comes on top.
    #[arg(long, default_value_t = 100.0, value_name = "R", allow_negative_numbers = true)]
    rtt_ms: f64,
    #[command(flatten)]
    rules: Rules,
    /// Rallies after which the game is over; without it, the time is.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=i64::from(RALLIES)))]
    rallies: Option<u16>,
    /// Of everything random.
    #[arg(long, default_value_t = 1, value_name = "K", allow_negative_numbers = true)]
    seed: u64,
    /// Round trips of 10 to 400 ms without a bound, with the ball's and with both, instead of one game.
    #[arg(long, conflicts_with_all = ["rtt_ms", "bounder", "motion_bounder"])]
    sweep: bool,
    /// Folder for pictures.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
enum Question {
    /// The game in real time over UDP, sealed: this process is its server or one of its players.
    Live(live::Live),
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
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        if let Some(Question::Live(live)) = &self.question {
            return live.run(ui);
        }
        check("--rtt-ms", self.rtt_ms, 0.0, 2000.0, "ms")?;
        let (bounder, motion_bounder, seconds) = self.rules.read()?;
        let scene = self.scene.load()?;
        let network = scene.world.network;
        // A line between two of many has no recording, no longer way back and no play-out; peers have clocks of their own.
        for (key, given) in [
            ("trace", scene.network_trace.is_some()),
            ("asymmetry_s", network.asymmetry_s != 0.0),
            ("playout_packets", network.playout_packets != 0),
            ("clock_drift_ppm", network.clock_drift_ppm != 0.0),
        ] {
            if given {
                return Err(
                    format!("network.{key} is not allowed here: a game of squash cannot take it into account").into()
                );
            }
        }
        let mut options = Options {
            players: self.players,
            round_trip_s: self.rtt_ms * 1e-3,
            network,
            bounder,
            motion_bounder,
            seconds,
            rallies: self.rallies.unwrap_or(RALLIES),
            seed: self.seed,
            changes: Vec::new(),
            record_every: 0,
        };
        if self.sweep {
            let cells = sweep(&options);
            ui.document(&cells)?;
            print_sweep(ui, &cells);
            return Ok(());
        }
        let folder = ui.folder(self.out.as_deref(), "out/squash");
        options.record_every = if folder.is_some() { 5 } else { 0 };
        let game = play(&options);
        let made = ui.made().settings(scene.settings()).with("players", options.players).with("seed", self.seed);
        let made = made.with("round_trip_ms", self.rtt_ms).with("seconds", seconds);
        let made = made.with("bounder", bounder).with("motion_bounder", motion_bounder);
        let name = self.scene.run_name(&scene);
        let files = ui.files(folder.as_deref(), &format!("squash-{name}-{}", self.seed), &made, |files| {
            files.figure(None, &picture::figure(&game, &options))
        })?;
        let document = Document {
            players: options.players,
            rtt_ms: self.rtt_ms,
            bounder,
            motion_bounder,
            seconds,
            seed: self.seed,
            report: game.report,
            files,
        };
        ui.document_of(&made, &document)?;
        document.print(ui);
        Ok(())
    }
}

fn yes(flag: bool) -> String {
    if flag { "yes" } else { "NO" }.to_owned()
}

fn print_sweep(ui: &Ui, cells: &[Cell]) {
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
    ui.table(&table);
}

impl Document {
    fn print(&self, ui: &Ui) {
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
        ui.table(&table);
        ui.wrote(&self.files);
    }
}
