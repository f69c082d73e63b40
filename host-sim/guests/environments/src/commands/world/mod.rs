//! `cohold shared world`: a static world on servers and at clients.

mod args;
mod crowd;
mod stroke;
mod visit;

use clap::Args;
use cohold_cli::flags::End;
use cohold_cli::{Failure, Ui};
use cohold_live::endpoint::{Endpoint, Stop};
use cohold_live::key_file;
use serde_json::json;

use crate::live::serve;
use crate::records::{Object, Region};
use crate::world::host::{Host, MOST_LINES};
use args::WorldArgs;

pub(crate) use args::world_keys;

cohold_cli::commands! {
    pub(crate) World {
        /// A server over UDP: the whole world, or one region of it.
        Serve(Serve),
        /// A client of one or several servers: downloads a world and feels it.
        Visit(visit::Visit),
        /// What a world holds; without one, every key of a world file.
        Show(Show),
        /// A hand strokes along an object of a world and pushes it about: force, depth at corners, energy.
        Stroke(stroke::Stroke),
        /// Very many clients at one server: how many it holds, and where it bends.
        Crowd(crowd::Crowd),
    }
}

#[derive(Debug, Args)]
#[command(mut_arg("seconds", |arg| arg.default_value("3600")))]
pub(crate) struct Serve {
    #[command(flatten)]
    world: WorldArgs,
    #[command(flatten)]
    end: End,
    /// Which region of the world, counted from 1; without it, everything.
    #[arg(long, value_name = "NUMBER")]
    region: Option<usize>,
    /// How many clients there may be: lines 1 to this.
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_LINES)))]
    lines: u32,
}

impl Serve {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
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
        let key = self.end.key.read()?;
        // A link refuses entropy that nobody has drawn.
        let entropy = || key_file::entropy().unwrap_or_default();
        let objects = world.objects().len();
        let mut host = Host::new(key, number, self.lines, *world, region, entropy)?;
        let endpoint = Endpoint::answering(self.end.listen)?;
        ui.status(format_args!("server {number} of {place}, {objects} objects, listens on {}", self.end.listen));
        let options = serve::Options { duration_s: self.end.time.seconds, warm_up_s: 0.0, sent_ns: |_| None };
        ui.report("server", &serve::run(&endpoint, &mut host, options, &Stop::on_signals()?)?)
    }
}

#[derive(Debug, Args)]
pub(crate) struct Show {
    #[command(flatten)]
    world: WorldArgs,
}

impl Show {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let Some((world, _)) = self.world.load()? else { return world_keys(ui) };
        let (objects, regions, version) = (world.objects().len(), world.regions().len(), world.version);
        // As it was written: 0.1, and not the f32 nearest to it.
        let margin_m: f64 = world.margin_m.to_string().parse()?;
        let checksum = format!("{:016x}", world.checksum()?);
        let bytes = objects * Object::LEN + regions * Region::LEN;
        writeln!(
            ui,
            "version {version}, checksum {checksum}: {objects} objects and {regions} regions in {bytes} bytes, margin {margin_m} m"
        );
        ui.document(&json!({
            "version": version, "checksum": checksum, "margin_m": margin_m, "objects": objects, "regions": regions, "bytes": bytes
        }))
    }
}
