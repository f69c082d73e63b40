//! `cohold board update`: another image for a board without a probe, by the bootloader in its chip.

use std::{net::SocketAddr, path::PathBuf};

use clap::Args;
use cohold_board_tools::{calibrate::board::say, image};
use cohold_io::{Kind, Most};
use cohold_live::operator::Operator;
use serde_json::json;

use super::operator::address;
use crate::flags::KeyFile;
use crate::{Failure, Ui};

/// An image with what a debugger wants of it has some 10 MB.
const ELF: Most = Most::new(64 << 20, "an image");

#[derive(Debug, Args)]
#[command(mut_arg("key_file", |arg| arg.help("The operator's key file that the board was provisioned with (`cohold key generate --operator`)")))]
pub(crate) struct Update {
    /// The board's address; its port is 7702 unless another is given.
    #[arg(long, value_name = "ADDRESS[:PORT]", value_parser = address)]
    board: SocketAddr,
    #[command(flatten)]
    key: KeyFile,
    /// The image that the board is to have: the ELF file that cargo built, or that of a release.
    #[arg(long, value_name = "FILE")]
    image: PathBuf,
}

impl Update {
    /// Writes the image's bytes beside it, has the board start its bootloader, and says what puts them into it.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let shown = self.image.display();
        let elf = cohold_io::read(&self.image, ELF).map_err(cohold_sim::Error::cannot("read", &shown))?;
        let bytes = image::flash(&elf).map_err(|why| format!("{shown}: {why}"))?;
        let mut file = self.image.clone().into_os_string();
        file.push(".bin");
        let file = PathBuf::from(file);
        cohold_io::write(&file, &bytes, Kind::Named).map_err(cohold_sim::Error::cannot("write", &file.display()))?;
        let mut operator = Operator::connect(self.board, &self.key.key_file)?;
        let answer = say(&mut operator, "update")?;
        ui.status(format_args!("board {}: {answer}", operator.number));
        let next = format!("dfu-util -d 0483:df11 -a 0 -s {:#010x} -D {}", image::BANK_1.start, file.display());
        writeln!(ui, "{next}");
        ui.status(
            "then press the board's black button: it starts as at power-on, with the keys and the settings that it had",
        );
        ui.document(&json!({ "answer": answer, "next": next, "files": [&file] }))
    }
}
