//! `host-sim world`: every key of a world file, or what a world holds.

use std::path::PathBuf;

use clap::Args;
use haptic_protocol::world::{Field, Shape};
use serde::Serialize;

use super::{Failure, Ui};
use crate::shared::world;
use haptic_sim::report::text::TextTable;

/// Arguments of `world`.
#[derive(Debug, Args)]
pub(super) struct World {
    /// World file (TOML) to check and sum up; without it, the keys are listed.
    #[arg(long, value_name = "WORLD")]
    scene: Option<PathBuf>,
}

#[derive(Serialize)]
struct Key {
    key: String,
    default: f32,
    unit: &'static str,
    allowed: String,
    meaning: &'static str,
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

impl World {
    /// Prints the keys or the summary.
    ///
    /// # Errors
    /// A bad world.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        match &self.scene {
            Some(path) => self.sum_up(ui, path),
            None => self.keys(ui),
        }
    }

    fn sum_up(&self, ui: &Ui, path: &std::path::Path) -> Result<(), Failure> {
        let world = world::load(path)?;
        let (objects, regions) = (world.objects().len(), world.regions().len());
        let summary = Summary {
            version: world.version,
            checksum: format!("{:016x}", world.checksum()?),
            margin_m: world.margin_m,
            objects,
            regions,
            bytes: objects * haptic_protocol::world::Object::LEN + regions * haptic_protocol::world::Region::LEN,
        };
        ui.document(&summary)?;
        writeln!(
            ui,
            "version {}, checksum {}: {objects} objects and {regions} regions in {} bytes, margin {} m",
            summary.version, summary.checksum, summary.bytes, summary.margin_m
        );
        Ok(())
    }

    fn keys(&self, ui: &Ui) -> Result<(), Failure> {
        let allowed = |field: &Field| {
            format!("{} {} to {}", if field.whole { "whole," } else { "number," }, field.min, field.max)
        };
        let own = world::OWN_KEYS.iter().map(|(table, field)| (*table, field));
        let shapes = Shape::ALL.iter().flat_map(|(name, _, fields)| fields.iter().map(move |field| (*name, field)));
        let keys: Vec<Key> = own
            .chain(shapes)
            .map(|(table, field)| Key {
                key: if table.is_empty() { field.name.to_owned() } else { format!("{table}.{}", field.name) },
                default: field.default,
                unit: field.unit,
                allowed: allowed(field),
                meaning: field.doc,
            })
            .collect();
        ui.document(&keys)?;
        let mut table = TextTable::new(["key", "default", "unit", "allowed", "meaning"]);
        for key in keys {
            table.push([key.key, key.default.to_string(), key.unit.to_owned(), key.allowed, key.meaning.to_owned()]);
        }
        ui.table(&table);
        Ok(())
    }
}
