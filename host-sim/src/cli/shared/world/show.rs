//! `host-sim shared world show`: what a world holds, or every key of a world file.

use clap::Args;
use serde::Serialize;

use crate::cli::flags::WorldArgs;
use crate::cli::{Failure, Ui, listings};

/// Arguments of `show`.
#[derive(Debug, Args)]
pub(in crate::cli) struct Show {
    #[command(flatten)]
    world: WorldArgs,
}

#[derive(Serialize)]
struct Summary {
    version: u32,
    checksum: String,
    margin_m: f32,
    objects: usize,
    regions: usize,
    bytes: usize,
}

impl Show {
    /// Prints the summary or the keys.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let Some((world, _)) = self.world.load()? else { return listings::world_keys(ui) };
        let (objects, regions) = (world.objects().len(), world.regions().len());
        let summary = Summary {
            version: world.version,
            checksum: format!("{:016x}", world.checksum()?),
            margin_m: world.margin_m,
            objects,
            regions,
            bytes: objects * haptic_protocol::world::Object::LEN + regions * haptic_protocol::world::Region::LEN,
        };
        writeln!(
            ui,
            "version {}, checksum {}: {objects} objects and {regions} regions in {} bytes, margin {} m",
            summary.version, summary.checksum, summary.bytes, summary.margin_m
        );
        ui.document(&summary)
    }
}
