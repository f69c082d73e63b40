//! `cohold shared world crowd`: how many clients a server holds.

use clap::Args;
use cohold_cli::flags::{Time, seconds};
use cohold_cli::{Failure, Ui};
use cohold_live::endpoint::Stop;
use serde_json::json;

use super::WorldArgs;
use crate::trials::{beside, crowd, load::Span};
use crate::{world, world::PACKET_US, world::host::MOST_LINES};

/// The turnaround that a server is held to, at the 99th percentile, µs.
const LIMIT_US: f64 = 1_000.0;
const RATE_HZ: f64 = 1e6 / PACKET_US as f64;

#[derive(Debug, Args)]
#[command(mut_arg("world", |arg| arg.help("World file (TOML) [default: the two rooms of scenes/worlds]")))]
#[command(mut_arg("seconds", |arg| arg.default_value("10")))]
pub(crate) struct Crowd {
    /// How many clients, one run for each, separated by commas.
    #[arg(long, value_delimiter = ',', default_values_t = [100, 200, 500, 1000, 1500, 2000], value_name = "N,…",
        value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_LINES)))]
    clients: Vec<u32>,
    #[command(flatten)]
    time: Time,
    /// How long before that the clients have to arrive and download, s.
    #[arg(long, default_value = "3", value_name = "S", value_parser = seconds)]
    warm_up_s: f64,
    /// Measure what the machine does without a server's work, too: after each run a bare echo under the same load, and sealing by
    /// ring and openssl.
    #[arg(long)]
    beside: bool,
    #[command(flatten)]
    world: WorldArgs,
}

/// Processes that ran or wanted to, mean over the last minute.
fn load() -> Option<f64> {
    std::fs::read_to_string("/proc/loadavg").ok()?.split_whitespace().next()?.parse().ok()
}

fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    name.map_or_else(|| std::env::consts::ARCH.to_owned(), |(_, name)| name.trim().to_owned())
}

/// Within the limit at the full rate, and hardly anything unanswered.
fn holds(run: &crowd::Report) -> bool {
    let full = run.rate_hz > 0.99 * RATE_HZ && run.answered_share() > 0.999 && run.complete == run.clients;
    full && run.server.turnaround.p99_us < LIMIT_US
}

impl Crowd {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let world = match self.world.load()? {
            Some((world, _)) => world,
            None => world::parse(include_str!("../../../../../sim/scenes/worlds/two-rooms.toml"), "two-rooms")?,
        };
        let mut clients = self.clients.clone();
        clients.sort_unstable();
        clients.dedup();
        let before = load();
        let (stop, mut runs) = (Stop::on_signals()?, Vec::new());
        ui.work(clients.len(), "crowds", |step| -> Result<(), Failure> {
            for count in clients.iter().take_while(|_| !stop.is_asked()) {
                let span = Span { warm_up_s: self.warm_up_s, seconds: self.time.seconds };
                let run = crowd::run(&world, *count, span, &stop)?;
                runs.push(if self.beside { run.beside_echo(span, &stop)? } else { run });
                step();
            }
            Ok(())
        })?;
        // The most clients of the runs up to the first that was over the limit, or lost answers; the fewest over the limit.
        let most = runs.iter().take_while(|run| holds(run)).last().map(|run| run.clients);
        let bends = runs.iter().find(|run| !holds(run)).map(|run| run.clients);
        let sealing = self.beside.then(beside::sealing).transpose()?;
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        ui.report(
            "crowd",
            &json!({
                "machine": { "processor": processor(), "cores": cores, "load": [before, load()] },
                "packets_per_s_each": RATE_HZ, "limit_us": LIMIT_US, "holds": most, "bends": bends, "sealing": sealing,
                "runs": runs,
            }),
        )?;
        writeln!(
            ui,
            "Held: the turnaround's 99th percentile below {LIMIT_US} us, every client has its world and sends at the full rate, and\n\
             more than 99.9 % of the packets are answered. Turnaround: from the time that a client handed its packet to the\n\
             system to the last answer sent; answer: from the batch in hand that it came in; round trip: at the client, its own delays\n\
             included. Where the rate falls the load is short of a core: what bends first then is the load, not the server.\n\
             Beyond one core or one machine, split the world: each region names its server, a server holds its region and the\n\
             margin around it, and clients move from one to the next by themselves (`serve --region`, `visit --server`). Clients\n\
             are aware of those at the same server only, so servers say nothing to each other."
        );
        Ok(())
    }
}
