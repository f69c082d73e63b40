//! Which world, and what may be in its file.

use std::path::PathBuf;

use clap::Args;
use cohold_cli::flags::listing;
use cohold_cli::listings::{key, say_keys};
use cohold_cli::{Failure, Ui};

use crate::records::{Field, Shape};
use crate::{world, world::World};

/// Which world.
#[derive(Clone, Debug, Args)]
#[command(arg(listing("world-keys", "List every key of a world file: unit, default, range, meaning").long("keys")))]
pub(super) struct WorldArgs {
    /// World file (TOML).
    #[arg(long, alias = "scene", value_name = "FILE")]
    world: Option<PathBuf>,
}

impl WorldArgs {
    /// The world, where one is named, and its file.
    pub(super) fn load(&self) -> Result<Option<(Box<World>, String)>, Failure> {
        let Some(path) = &self.world else { return Ok(None) };
        Ok(Some((world::load(path)?, path.display().to_string())))
    }
}

/// Prints every key of a world file.
pub(crate) fn world_keys(ui: &Ui) -> Result<(), Failure> {
    let own = world::own_keys();
    let shapes = Shape::ALL.iter().flat_map(|(name, _, fields)| fields.iter().map(move |field| (*name, field)));
    let row = |(table, field): (&str, &Field)| {
        let name = [table, field.name].join(".").trim_start_matches('.').to_owned();
        // As it was declared: 0.1, and not the f32 nearest to it.
        let default = field.default.to_string().parse::<f64>().ok();
        let kind = if field.whole { "whole," } else { "number," };
        key(name, default, field.unit, &format!("{kind} {} to {}", field.min, field.max), field.doc)
    };
    say_keys(ui, &own.chain(shapes).map(row).collect::<Vec<_>>())
}
