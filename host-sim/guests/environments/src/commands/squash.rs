//! `cohold shared squash`: Force Feedback Multi-player Squash, played by bots.

use std::net::SocketAddr;

use clap::{ArgAction, Args, Subcommand};
use cohold_cli::address::endpoint;
use cohold_cli::flags::{KeyFile, Out, Time, number, switch};
use cohold_cli::ui::and;
use cohold_cli::{Failure, SceneArgs, Ui};
use cohold_live::endpoint::Stop;
use cohold_report::Columns;
use serde_json::json;

use crate::live::squash as live;
use crate::roles::squash::RALLIES;
use crate::squash::{Cell, Options, picture, play, sweep};

/// What a game goes by, simulated or live.
#[derive(Clone, Copy, Debug, Args)]
#[command(mut_arg("seconds", |arg| arg.default_value("60")))]
struct Rules {
    /// Bounds the speed of the ball; live, the server's word.
    #[arg(long, default_value = "on", action = ArgAction::Set, value_parser = switch())]
    bounder: bool,
    /// Damps the hands of the players; live, of this one.
    #[arg(long, default_value = "on", action = ArgAction::Set, value_parser = switch())]
    motion_bounder: bool,
    #[command(flatten)]
    time: Time,
}

#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct Squash {
    #[command(subcommand)]
    question: Option<Question>,
    #[command(flatten)]
    scene: SceneArgs,
    /// Players.
    #[arg(long, default_value_t = 4, value_name = "N", value_parser = clap::value_parser!(u8).range(2..=8))]
    players: u8,
    /// Round trip between any two, ms, instead of the scene's network.one_way_delay_packets; what else its network does to
    /// packets comes on top.
    #[arg(long, default_value = "100", value_name = "R", value_parser = number(0.0..=2000.0, "ms"))]
    rtt_ms: f64,
    #[command(flatten)]
    rules: Rules,
    /// Rallies after which the game is over; without it, the time is.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=i64::from(RALLIES)))]
    rallies: Option<u16>,
    /// Round trips of 10 to 400 ms without a bound, with the ball's and with both, instead of one game.
    #[arg(long, conflicts_with_all = ["rtt_ms", "bounder", "motion_bounder"])]
    sweep: bool,
    #[command(flatten)]
    out: Out,
}

#[derive(Debug, Subcommand)]
enum Question {
    /// The game in real time over UDP, sealed: this process is its server or one of its players.
    Live(Live),
}

impl Squash {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        if let Some(Question::Live(live)) = &self.question {
            return live.run(ui);
        }
        let Rules { bounder, motion_bounder, time: Time { seconds } } = self.rules;
        let scene = self.scene.load(ui)?;
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
            seed: network.seed.into(),
            changes: Vec::new(),
            record_every: 0,
        };
        if self.sweep {
            let cells = sweep(&options);
            ui.document(&cells)?;
            print_sweep(ui, &cells);
            return Ok(());
        }
        options.record_every = if ui.writes(&self.out) { 5 } else { 0 };
        let game = play(&options);
        let provenance = ui.provenance().settings(scene.settings()).with("players", options.players);
        let provenance = provenance.with("round_trip_ms", self.rtt_ms).with("seconds", seconds);
        let provenance = provenance.with("bounder", bounder).with("motion_bounder", motion_bounder);
        let name = self.scene.run_name(&scene);
        let files = ui.files(&self.out, "squash", &format!("squash-{name}"), &provenance, |files| {
            files.figure(None, &picture::figure(&game, &options))
        })?;
        let summary = json!({
            "players": self.players, "rtt_ms": self.rtt_ms, "bounder": bounder, "motion_bounder": motion_bounder,
            "seconds": seconds, "seed": options.seed,
        });
        let summary = and(summary, &game.report)?;
        ui.report_of(&provenance, "squash", &and(summary, &json!({ "files": files }))?)
    }
}

fn print_sweep(ui: &Ui, cells: &[Cell]) {
    let table = Columns::of(cells)
        .number("round_trip_ms", 0, |cell| cell.round_trip_ms)
        .value("bounder", |cell| cell.bounder)
        .value("rallies", |cell| cell.report.rallies)
        .value("strokes", |cell| cell.report.strokes)
        .value("left_the_court", |cell| cell.report.left_the_court)
        .value("agreed", |cell| cell.report.agreed)
        .number("fastest_m_per_s", 1, |cell| cell.report.fastest_m_per_s)
        .number("flown_before_news_m", 2, |cell| cell.report.farthest_before_news_m)
        .number("correction_m", 2, |cell| cell.report.largest_correction_m)
        .number("hand_in_a_round_trip_m", 2, |cell| cell.report.hand_travel_m)
        .done();
    ui.table(&table);
}

#[derive(Debug, Args)]
struct Live {
    /// Which one: 0 is the server, 1, 2 … the players.
    #[arg(long, value_name = "N")]
    number: u8,
    /// Where each of them listens, in order, the server first; the same for all.
    #[arg(long, value_name = "ADDRESS:PORT,…", value_parser = endpoint, value_delimiter = ',', required = true)]
    addresses: Vec<SocketAddr>,
    #[command(flatten)]
    key: KeyFile,
    #[command(flatten)]
    rules: Rules,
}

impl Live {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let Rules { bounder, motion_bounder, time: Time { seconds } } = self.rules;
        for (at, address) in self.addresses.iter().enumerate() {
            if self.addresses[..at].contains(address) {
                return Err(format!("--addresses has {address} twice: each of them has one of its own").into());
            }
        }
        let key = self.key.read()?;
        let addresses = self.addresses.clone();
        let options = live::Options { number: self.number, addresses, bounder, motion_bounder, seconds };
        ui.report("squash", &live::run(&key, &options, &Stop::on_signals()?)?)
    }
}
