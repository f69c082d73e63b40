//! `host-sim key`: keys of sealed lines.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::{Failure, Ui};
use crate::shared::world::host::MOST_LINES;
use haptic_sim::key_file;

super::commands! {
    Key {
        /// Make a key file: for two peers, or for one line of a server or hub.
        #[command(alias = "keygen")]
        Generate(Generate),
        /// The key as a board keeps it in flash, for `cargo xtask provision`.
        #[command(alias = "key-image")]
        Image(Image),
    }
}

#[derive(Debug, Args)]
pub(in crate::cli) struct Generate {
    /// File to make; an existing one is left alone.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The key of one line of a server or a hub, made from its key.
    #[arg(long, value_name = "NUMBER", requires = "of", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_LINES)))]
    line: Option<u32>,
    /// The server's or hub's key file.
    #[arg(long, value_name = "FILE", requires = "line")]
    of: Option<PathBuf>,
}

impl Generate {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let file = self.file.display();
        match (self.line, &self.of) {
            (Some(line), Some(of)) => {
                key_file::write(&self.file, &key_file::read(of)?.line(line))?;
                writeln!(ui, "wrote {file}: for line {line}; copy it there over a way that you trust");
            }
            _ => {
                key_file::generate(&self.file)?;
                writeln!(ui, "wrote {file}: copy it to the other peer over a way that you trust");
            }
        }
        ui.document(&json!({ "files": [&self.file] }))
    }
}

#[derive(Debug, Args)]
pub(in crate::cli) struct Image {
    /// Key file (`host-sim key generate`).
    #[arg(value_name = "FILE")]
    key_file: PathBuf,
    /// File to make, as secret as the key; an existing one is left alone.
    #[arg(value_name = "IMAGE")]
    image: PathBuf,
}

impl Image {
    /// Writes the key as a board keeps it in flash; `cargo xtask provision` puts it there.
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        key_file::write_secret(&self.image, &key_file::read(&self.key_file)?.image())?;
        ui.document(&json!({ "files": [&self.image] }))
    }
}
