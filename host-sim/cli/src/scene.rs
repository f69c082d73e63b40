//! `cohold scene`: scene files.

use std::io::Write as _;
use std::path::PathBuf;

use clap::Args;
use cohold_sim::{Error, scenes};
use serde_json::json;

use super::{Failure, Ui};

super::commands! {
    pub(crate) Scene {
        /// Write a commented scene file to start from. It lists what differs from a built-in scene.
        New(New),
    }
}

#[derive(Debug, Args)]
pub(crate) struct New {
    /// File to make; an existing one is left alone.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Built-in scene that it changes (`cohold cooperate --scenes` lists them).
    #[arg(long, value_name = "SCENE", default_value = "any-network")]
    base: String,
}

impl New {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let (file, base) = (self.file.display(), &self.base);
        scenes::load(ui.laws, base)?;
        let text = START.replace("BASE", base).replace("FILE", &file.to_string());
        let write = |mut made: std::fs::File| made.write_all(text.as_bytes());
        cohold_io::begin(&self.file).and_then(write).map_err(Error::cannot("make", &file))?;
        writeln!(ui, "wrote {file}. Next: cohold cooperate --scene {file}");
        ui.document(&json!({ "files": [&self.file] }))
    }
}

/// What such a file begins with.
const START: &str = include_str!("scene.toml");

#[cfg(test)]
#[path = "../tests/inside/scene.rs"]
mod tests;
