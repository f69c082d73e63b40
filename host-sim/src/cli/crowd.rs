//! `host-sim crowd`: how many clients a server holds.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::{Failure, Ui};
use crate::live::endpoint::Stop;
use crate::shared::world;
use crate::shared::world::PACKET_US;
use crate::shared::world::host::MOST_LINES;
use crate::trials::crowd;
use haptic_sim::report::text::TextTable;

/// The turnaround that a server is held to, at the 99th percentile, µs.
const LIMIT_US: f64 = 1_000.0;
/// Packets of a client a second.
const RATE_HZ: f64 = 1e6 / PACKET_US as f64;

/// Arguments of `crowd`.
#[derive(Debug, Args)]
pub(super) struct Crowd {
    /// How many clients, one run for each, separated by commas.
    #[arg(long, allow_negative_numbers = true, value_delimiter = ',', default_values_t = [100, 200, 500, 1000, 1500, 2000], value_name = "N,…",
        value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_LINES)))]
    clients: Vec<u32>,
    /// How long each run is measured, s.
    #[arg(long, default_value_t = 10.0, value_name = "S", allow_negative_numbers = true)]
    seconds: f64,
    /// How long before that the clients have to arrive and download, s.
    #[arg(long, default_value_t = 3.0, value_name = "S", allow_negative_numbers = true)]
    warm_up_s: f64,
    /// World file; without it, the two rooms of `scenes/worlds`.
    #[arg(long, value_name = "WORLD")]
    scene: Option<PathBuf>,
}

/// What the machine was while it was measured.
#[derive(Debug, Serialize)]
struct Machine {
    processor: String,
    cores: usize,
    /// Processes that ran or wanted to, mean over the last minute, before and after.
    load: [Option<f64>; 2],
}

fn load() -> Option<f64> {
    std::fs::read_to_string("/proc/loadavg").ok()?.split_whitespace().next()?.parse().ok()
}

fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    name.map_or_else(|| std::env::consts::ARCH.to_owned(), |(_, name)| name.trim().to_owned())
}

#[derive(Debug, Serialize)]
struct Document {
    machine: Machine,
    packets_per_s_each: f64,
    limit_us: f64,
    /// The most clients of the runs up to the first that was over the limit, or lost answers.
    holds: Option<u32>,
    /// The fewest clients over the limit.
    bends: Option<u32>,
    runs: Vec<crowd::Report>,
}

/// Within the limit at the full rate, and hardly anything unanswered.
fn holds(run: &crowd::Report) -> bool {
    let full = run.rate_hz > 0.99 * RATE_HZ && run.answered_share() > 0.999 && run.complete == run.clients;
    full && run.server.turnaround.p99_us < LIMIT_US
}

impl Crowd {
    /// Measures and reports.
    ///
    /// # Errors
    /// A bad world or time; a socket that cannot be opened.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        super::live::check_time("--seconds", self.seconds)?;
        super::live::check_time("--warm-up-s", self.warm_up_s)?;
        let world = match &self.scene {
            Some(path) => world::load(path)?,
            None => world::parse(include_str!("../../../scenes/worlds/two-rooms.toml"), "two-rooms")?,
        };
        let mut clients = self.clients.clone();
        clients.sort_unstable();
        clients.dedup();
        let before = load();
        let progress = ui.progress(clients.len() as u64, "crowds");
        let (stop, mut runs) = (Stop::on_signals()?, Vec::new());
        for count in clients {
            runs.push(crowd::run(&world, count, self.warm_up_s, self.seconds, &stop)?);
            progress.inc(1);
            if stop.is_asked() {
                break;
            }
        }
        progress.finish_and_clear();
        let machine = Machine {
            processor: processor(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            load: [before, load()],
        };
        let document = Document {
            machine,
            packets_per_s_each: RATE_HZ,
            limit_us: LIMIT_US,
            holds: runs.iter().take_while(|run| holds(run)).last().map(|run| run.clients),
            bends: runs.iter().find(|run| !holds(run)).map(|run| run.clients),
            runs,
        };
        ui.document(&document)?;
        print(ui, &document);
        Ok(())
    }
}

fn print(ui: &Ui, document: &Document) {
    let Machine { processor, cores, load } = &document.machine;
    let [before, after] = load.map(|load| load.map_or_else(|| "?".to_owned(), |load| format!("{load:.2}")));
    writeln!(
        ui,
        "{processor}, {cores} cores, load {before} before and {after} after; loopback UDP, {RATE_HZ} packets/s a client\n"
    );
    let mut table = TextTable::new([
        "clients",
        "rate Hz",
        "answered %",
        "turnaround p50 us",
        "p99 us",
        "p99.9 us",
        "answer p50 us",
        "p99 us",
        "round trip p50 us",
        "p99 us",
        "server core %",
        "load core %",
        "load late p99 us",
    ]);
    let share = |share: Option<f64>| share.map_or_else(|| "?".to_owned(), |share| format!("{:.0}", 100.0 * share));
    for run in &document.runs {
        let (turnaround, answer, trip) = (run.server.turnaround, run.server.answer, run.round_trip);
        table.push([
            run.clients.to_string(),
            format!("{:.1}", run.rate_hz),
            format!("{:.2}", 100.0 * run.answered_share()),
            format!("{:.1}", turnaround.p50_us),
            format!("{:.1}", turnaround.p99_us),
            format!("{:.1}", turnaround.p999_us),
            format!("{:.1}", answer.p50_us),
            format!("{:.1}", answer.p99_us),
            format!("{:.1}", trip.p50_us),
            format!("{:.1}", trip.p99_us),
            share(run.server.cpu_share),
            share(run.load_cpu_share),
            format!("{:.1}", run.load_late.p99_us),
        ]);
    }
    ui.table(&table);
    match (document.holds, document.bends) {
        (Some(holds), None) => writeln!(ui, "The server holds {holds} clients, the most that were tried."),
        (Some(holds), Some(bends)) => writeln!(ui, "The server holds {holds} clients and bends by {bends}."),
        (None, _) => writeln!(ui, "The server holds none of these crowds within the limit."),
    }
    writeln!(
        ui,
        "Held: the turnaround's 99th percentile below {LIMIT_US} us, every client has its world and sends at the full rate, and\n\
         more than 99.9 % of the packets are answered. Turnaround: from the time that a client handed its packet to the\n\
         system to the last answer sent; answer: from the datagram in hand; round trip: at the client, its own delays\n\
         included. Where the rate falls the load is short of a core: what bends first then is the load, not the server."
    );
    writeln!(
        ui,
        "Beyond one core or one machine, split the world: each region names its server, a server holds its region and the\n\
         margin around it, and clients move from one to the next by themselves (`serve --region`, `visit --server`). Clients\n\
         are aware of those at the same server only, so servers say nothing to each other."
    );
}
