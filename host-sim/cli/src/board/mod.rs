//! `cohold board`: a PC beside a board.

mod bringup;
mod calibrate;
mod operator;
mod update;

use std::path::PathBuf;

use clap::Args;
use cohold_studies::record::record;
use serde_json::json;

use crate::flags::{Time, number};
use crate::{Failure, SceneArgs, Ui};

pub use operator::address;

super::commands! {
    pub(crate) Board {
        /// Say lines to a board: arm, stop, set up; sealed.
        Operator(operator::Operate),
        /// The first hour: light, stop, encoder, sign, current, motor, lowest force, first contact, stop, cable; each checks before it goes on.
        Bringup(bringup::BringUp),
        /// What a board's encoders and motors are, found together with the person at it; leaves a settings file.
        #[command(subcommand)]
        Calibrate(calibrate::Calibrate),
        /// Another image for a board without a probe: its bytes beside the file, the board in its bootloader, and the command to go on with.
        Update(update::Update),
        /// What one peer of a scene reads, for the same peer on another processor.
        Record(Record),
    }
}

#[derive(Debug, Args)]
#[command(mut_arg("seconds", |arg| arg.default_value("5").value_parser(number(1e-5..=3600.0, "s"))))]
pub(crate) struct Record {
    #[command(flatten)]
    scene: SceneArgs,
    /// Which peer, 1 or 2.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=2))]
    number: u8,
    #[command(flatten)]
    time: Time,
    /// File to write.
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

impl Record {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load_of_one_axis(ui)?;
        let ticks = (self.time.seconds / scene.peer.timing.control_period_s).round() as u64;
        let recording = record(&scene, usize::from(self.number), ticks)?;
        cohold_io::write(&self.file, &recording.bytes, cohold_io::Kind::Named)
            .map_err(cohold_sim::Error::cannot("write", &self.file.display()))?;
        writeln!(ui, "{} ticks {:016x}", recording.ticks, recording.hash);
        let hash = format!("{:016x}", recording.hash);
        ui.document(&json!({ "ticks": recording.ticks, "hash": hash, "files": [&self.file] }))
    }
}
