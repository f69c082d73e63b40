//! `cohold shared world visit`: a client of a static world.

use std::{net::SocketAddr, path::PathBuf};

use clap::Args;
use cohold_cli::flags::{End, number, seconds};
use cohold_cli::{Failure, Ui};
use cohold_live::{endpoint::Stop, key_file};
use cohold_protocol::key::Role;

use crate::world::visitor::{Correspondent, Setup};
use crate::{live::visit, world::host::MOST_LINES};

#[derive(Debug, Args)]
#[command(mut_arg("seconds", |arg| arg.default_value("10")))]
#[command(mut_arg("listen", |arg| arg.required(false).default_value("0.0.0.0:0")))]
pub(crate) struct Visit {
    #[command(flatten)]
    end: End,
    /// This client's line.
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_LINES)))]
    line: u32,
    /// A server and where it listens; one for each region, the first is where the visit begins.
    #[arg(long = "server", required = true, value_name = "NUMBER=ADDRESS:PORT", value_parser = server)]
    servers: Vec<(u8, SocketAddr)>,
    /// How far around the hand the world is wanted, m; without it, everything.
    #[arg(long, value_name = "M", value_parser = number(1e-3..=1000.0, "m"))]
    radius_m: Option<f64>,
    /// The hand goes from here, m.
    #[arg(long, default_value = "0,0.1", value_name = "X,Y", value_parser = point, allow_hyphen_values = true)]
    from_m: [f64; 2],
    /// To here and back, m.
    #[arg(long, default_value = "0,-0.11", value_name = "X,Y", value_parser = point, allow_hyphen_values = true)]
    to_m: [f64; 2],
    /// In this time, s.
    #[arg(long, default_value = "2", value_name = "S", value_parser = seconds)]
    stroke_s: f64,
    /// Another client that is told straight where this one is, by its line and where it listens.
    #[arg(long, value_name = "LINE=ADDRESS:PORT", value_parser = friend, requires = "friend_key_file")]
    friend: Option<(u32, SocketAddr)>,
    /// Key file of the two (`cohold key generate`).
    #[arg(long, value_name = "FILE", requires = "friend")]
    friend_key_file: Option<PathBuf>,
}

fn numbered(text: &str) -> Result<(u32, SocketAddr), Failure> {
    let (number, address) = text.split_once('=').ok_or("write it as NUMBER=ADDRESS:PORT")?;
    let number = number.parse().map_err(|_| format!("{number} is no number"))?;
    Ok((number, cohold_cli::address::endpoint(address)?))
}

fn server(text: &str) -> Result<(u8, SocketAddr), Failure> {
    let (number, address) = numbered(text)?;
    match u8::try_from(number) {
        Ok(number @ 1..=254) => Ok((number, address)),
        _ => Err("a server's number is from 1 to 254".into()),
    }
}

fn friend(text: &str) -> Result<(u32, SocketAddr), Failure> {
    match numbered(text)? {
        (1..=MOST_LINES, _) => numbered(text),
        _ => Err(format!("a line is from 1 to {MOST_LINES}").into()),
    }
}

fn point(text: &str) -> Result<[f64; 2], Failure> {
    let parts: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    match parts.as_deref() {
        Some([x, y]) if [x, y].iter().all(|part| part.abs() <= 1000.0) => Ok([*x, *y]),
        _ => Err("write it as X,Y, each from -1000 to 1000 m".into()),
    }
}

impl Visit {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        for (at, (number, address)) in self.servers.iter().enumerate() {
            for (known, same) in &self.servers[..at] {
                if known == number || same == address {
                    return Err(format!(
                        "--server {known}={same} and --server {number}={address} are not allowed together: each server \
                         has a number and an address of its own"
                    )
                    .into());
                }
            }
        }
        let friend = match (self.friend, &self.friend_key_file) {
            (Some((line, _)), _) if line == self.line => {
                return Err(format!("--friend {line} is not allowed: that is this client's own line").into());
            }
            (Some((line, _)), Some(file)) => Some((line, key_file::read(file, Role::Peers)?)),
            _ => None,
        };
        let setup = Setup {
            key: self.end.key.read()?,
            line: self.line,
            home: self.servers.first().map_or(1, |(number, _)| *number),
            reachable: self.servers.iter().map(|(number, _)| *number).collect(),
            radius_m: self.radius_m.map(|radius_m| radius_m as f32),
        };
        let servers = self.servers.iter().map(|(number, address)| (Correspondent::Server(*number), *address));
        let options = visit::Options {
            setup,
            listen: self.end.listen,
            parties: servers.chain(self.friend.map(|(line, address)| (Correspondent::Client(line), address))).collect(),
            from_m: self.from_m,
            to_m: self.to_m,
            stroke_s: self.stroke_s,
            duration_s: self.end.time.seconds,
            friend,
        };
        ui.report("visit", &visit::run(&options, &Stop::on_signals()?)?)
    }
}
