//! `host-sim shared world serve`: a server of a static world.

use std::net::SocketAddr;

use clap::Args;

use crate::cli::flags::{KeyFile, Time, WorldArgs};
use crate::cli::{Failure, Ui, granted};
use crate::live::endpoint::{Endpoint, Stop};
use crate::live::serve;
use crate::shared::world::host::{Host, MOST_LINES};
use haptic_sim::key_file;

/// Arguments of `serve`.
#[derive(Debug, Args)]
#[command(mut_arg("seconds", |arg| arg.default_value("3600")))]
pub(in crate::cli) struct Serve {
    #[command(flatten)]
    world: WorldArgs,
    /// Where the server listens.
    #[arg(long, value_name = "ADDRESS:PORT")]
    listen: SocketAddr,
    #[command(flatten)]
    key: KeyFile,
    /// Which region of the world, counted from 1; without it, everything.
    #[arg(long, value_name = "NUMBER")]
    region: Option<usize>,
    /// How many clients there may be: lines 1 to this.
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_LINES)))]
    lines: u32,
    #[command(flatten)]
    time: Time,
}

impl Serve {
    /// Serves until the time is over, and reports.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let (world, place) = self.world.load()?.ok_or("--world is missing: what is served")?;
        let (number, region) = match self.region {
            None => (1, None),
            Some(wanted) => {
                let most = world.regions().len();
                let region =
                    wanted.checked_sub(1).and_then(|at| world.regions().get(at)).ok_or_else(|| match most {
                        0 => format!("--region {wanted} is not allowed: {place} has no regions"),
                        _ => format!("--region {wanted} is not allowed: {place} has regions 1 to {most}"),
                    })?;
                (region.server, Some(region.id))
            }
        };
        let key = self.key.read()?;
        // A link refuses entropy that nobody has drawn.
        let entropy = || key_file::entropy().unwrap_or_default();
        let objects = world.objects().len();
        let mut host = Host::new(key, number, self.lines, *world, region, entropy)?;
        let endpoint = Endpoint::answering(self.listen)?;
        ui.status(format_args!("server {number} of {place}, {objects} objects, listens on {}", self.listen));
        let options = serve::Options { duration_s: self.time.seconds, warm_up_s: 0.0, sent_ns: |_| None };
        let report = serve::run(&endpoint, &mut host, options, &Stop::on_signals()?)?;
        ui.document(&report)?;
        let counts = report.counts;
        writeln!(
            ui,
            "{} datagrams came, {} went, {} were refused; {} questions, {} parts, {} places; {} clients at once",
            counts.received, counts.sent, counts.refused, counts.asks, counts.parts, counts.presences, report.clients
        );
        writeln!(
            ui,
            "turnaround: half below {:.1} us, 99 % below {:.1} us, the longest {:.1} us; real-time priority: {}",
            report.turnaround.p50_us,
            report.turnaround.p99_us,
            report.turnaround.largest_us,
            granted(report.realtime_priority)
        );
        Ok(())
    }
}
