//! `cohold key`: keys of sealed lines.

use std::path::PathBuf;

use clap::Args;
use cohold_live::key_file;
use cohold_protocol::key::{Key as SecretKey, Role};
use serde_json::json;

use super::{Failure, Ui};

super::commands! {
    pub(crate) Key {
        /// Make a key file: for two peers, for one line of a server or hub, or for the operator of a board.
        Generate(Generate),
        /// A board's two keys as it keeps them in flash, for `cargo xtask provision`.
        Image(Image),
    }
}

#[derive(Debug, Args)]
pub(crate) struct Generate {
    /// File to make; an existing one is left alone.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The key of one line of a server or a hub, made from its key.
    #[arg(long, value_name = "NUMBER", requires = "of", value_parser = clap::value_parser!(u32).range(1..=i64::from(SecretKey::MOST_LINES)))]
    line: Option<u32>,
    /// The server's or hub's key file.
    #[arg(long, value_name = "FILE", requires = "line")]
    of: Option<PathBuf>,
    /// The key of a board's operator, which no peer is to hold.
    #[arg(long, conflicts_with_all = ["line", "of"])]
    operator: bool,
}

impl Generate {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let file = self.file.display();
        match (self.line, &self.of) {
            (Some(line), Some(of)) => {
                key_file::write(&self.file, Role::Peers, &key_file::read(of, Role::Peers)?.line(line))?;
                writeln!(ui, "wrote {file}: for line {line}; copy it there over a way that you trust");
            }
            _ if self.operator => {
                key_file::generate(&self.file, Role::Operator)?;
                writeln!(
                    ui,
                    "wrote {file}: who has it can arm the boards that are given it; keep it on the operator's PC"
                );
            }
            _ => {
                key_file::generate(&self.file, Role::Peers)?;
                writeln!(ui, "wrote {file}: copy it to the other peer over a way that you trust");
            }
        }
        ui.document(&json!({ "files": [&self.file] }))
    }
}

#[derive(Debug, Args)]
pub(crate) struct Image {
    /// Key file of the peers, or of the board's line to a hub (`cohold key generate`).
    #[arg(long, value_name = "FILE")]
    key_file: PathBuf,
    /// Key file of the operator (`cohold key generate --operator`).
    #[arg(long, value_name = "FILE")]
    operator_key_file: PathBuf,
    /// File to make, as secret as the keys; an existing one is left alone.
    #[arg(value_name = "IMAGE")]
    image: PathBuf,
}

impl Image {
    /// Writes the keys as a board keeps them in flash; `cargo xtask provision` puts them there.
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let peers = key_file::read(&self.key_file, Role::Peers)?;
        let operator = key_file::read(&self.operator_key_file, Role::Operator)?;
        if peers == operator {
            let (one, other) = (self.key_file.display(), self.operator_key_file.display());
            return Err(format!(
                "{one} and {other} hold the same key: who has the peers' could arm the board; `cohold key generate` makes another"
            )
            .into());
        }
        key_file::write_secret(&self.image, &[peers.image(Role::Peers), operator.image(Role::Operator)].concat())?;
        ui.document(&json!({ "files": [&self.image] }))
    }
}
