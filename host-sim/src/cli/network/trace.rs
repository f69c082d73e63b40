//! `host-sim network trace`: what a scene's network does to every packet, in a file that replays it.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use crate::cli::flags::Time;
use crate::cli::{Failure, SceneArgs, Ui};
use haptic_sim::network::rule::NetworkTrace;

/// Arguments of `trace`.
#[derive(Debug, Args)]
pub(in crate::cli) struct Trace {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    time: Time,
    /// CSV file to write.
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

impl Trace {
    /// Writes what the scene's network would do to a file that replays it.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        let timing = &scene.peer.timing;
        let packet_s = timing.packet_period_s();
        NetworkTrace::record(&scene, (self.time.seconds / packet_s).ceil() as u64).write(&self.file)?;
        writeln!(ui, "wrote {}", self.file.display());
        ui.document(&json!({ "files": [&self.file] }))
    }
}
