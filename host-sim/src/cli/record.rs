//! `host-sim record`: a recording for another processor, and the hash that it must come to.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::{Failure, SceneArgs, Ui};
use crate::studies::record::record;
use haptic_sim::scenes;

/// Arguments of `record`.
#[derive(Debug, Args)]
pub(super) struct Record {
    #[command(flatten)]
    scene: SceneArgs,
    /// A built-in scene instead of a file.
    #[arg(long, value_name = "NAME", conflicts_with_all = ["scene", "set"])]
    built_in: Option<String>,
    /// Which peer, 1 or 2.
    #[arg(long, default_value_t = 1, allow_negative_numbers = true, value_parser = clap::value_parser!(u8).range(1..=2))]
    number: u8,
    /// How long, s.
    #[arg(long, default_value_t = 5.0, value_name = "S", allow_negative_numbers = true)]
    duration_s: f64,
    /// File to write.
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

impl Record {
    /// Writes the recording and prints what it comes to.
    ///
    /// # Errors
    /// A bad scene or duration, or a file that cannot be written.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        if !(self.duration_s > 0.0 && self.duration_s <= 3600.0) {
            return Err(
                format!("--duration-s {} is not allowed: it must be above 0 and up to 3600", self.duration_s).into()
            );
        }
        let scene = match &self.built_in {
            Some(name) => scenes::load(name)?,
            None => self.scene.load()?,
        };
        let ticks = (self.duration_s / scene.peer.timing.control_period_s).round() as u64;
        let recording = record(&scene, usize::from(self.number), ticks)?;
        std::fs::write(&self.file, &recording.bytes)
            .map_err(|cause| format!("cannot write {}: {cause}", self.file.display()))?;
        writeln!(ui, "{} ticks {:016x}", recording.ticks, recording.hash);
        let hash = format!("{:016x}", recording.hash);
        ui.document(&json!({ "ticks": recording.ticks, "hash": hash, "files": [&self.file] }))
    }
}
