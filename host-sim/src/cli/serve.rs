//! `host-sim serve`: a server of a static world.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::Args;

use super::live::check_time;
use super::{Failure, Ui, granted};
use crate::live::endpoint::{Endpoint, Stop};
use crate::live::serve;
use crate::shared::world;
use crate::shared::world::host::{Host, MOST_LINES};
use haptic_sim::key_file;

/// Arguments of `serve`.
#[derive(Debug, Args)]
pub(super) struct Serve {
    /// World file (TOML); `host-sim world` lists its keys.
    #[arg(long, value_name = "WORLD")]
    scene: PathBuf,
    /// Where the server listens.
    #[arg(long, value_name = "ADDRESS:PORT")]
    listen: SocketAddr,
    /// The server's key file (`host-sim keygen`); its clients' are made from it (`--line`, `--of`).
    #[arg(long, value_name = "FILE")]
    key_file: PathBuf,
    /// Which region of the world, counted from 1; without it, everything.
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true)]
    region: Option<usize>,
    /// How many clients there may be: lines 1 to this.
    #[arg(long, default_value_t = 64, allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_LINES)))]
    lines: u32,
    /// How long, s.
    #[arg(long, default_value_t = 3600.0, value_name = "S", allow_negative_numbers = true)]
    duration_s: f64,
}

impl Serve {
    /// Serves until the time is over, and reports.
    ///
    /// # Errors
    /// A bad world, key file, region or address.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        check_time("--duration-s", self.duration_s)?;
        let world = world::load(&self.scene)?;
        let place = self.scene.display();
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
        let key = key_file::read(&self.key_file)?;
        // A link refuses entropy that nobody has drawn.
        let entropy = || key_file::entropy().unwrap_or_default();
        let objects = world.objects().len();
        let mut host = Host::new(key, number, self.lines, *world, region, entropy)?;
        let endpoint = Endpoint::answering(self.listen)?;
        ui.status(format_args!("server {number} of {place}, {objects} objects, listens on {}", self.listen));
        let options = serve::Options { duration_s: self.duration_s, warm_up_s: 0.0, sent_ns: |_| None };
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
