//! `host-sim stability`: verdicts, limits and regions, from the code that flies.

mod bench;
mod limit;
mod map;
mod paper;
mod point;

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use super::Failure;
use haptic_sim::report::table::Table;
use haptic_sim::report::{ReportError, files};

/// Arguments of `stability`.
#[derive(Debug, Args)]
pub(super) struct Stability {
    #[command(subcommand)]
    question: Question,
}

#[derive(Debug, Subcommand)]
enum Question {
    /// Is this scene stable? Spectral radius of one packet period, rest modes left out.
    Point(point::Point),
    /// At which values of one key does that change? All of them, pockets included.
    Limit(limit::Limit),
    /// The region in two keys, as file and picture.
    Map(map::Map),
    /// Figure 4 of the cooperation paper: three ways to communicate, four delays.
    Paper(paper::Paper),
    /// Figure 4 of the architectures paper: one device, one object, largest stiffness against delay and sampling period.
    Rendering(super::rendering::Rendering),
    /// The stiffest contact and coordination that leave a margin, for this device, network and loop.
    Tune(super::tune::Tune),
    /// Spectral radii per second.
    Bench(bench::Bench),
}

impl Stability {
    /// Answers the question.
    ///
    /// # Errors
    /// A bad scene, key or range; a file that cannot be written.
    pub(super) fn run(&self) -> Result<(), Failure> {
        match &self.question {
            Question::Point(point) => point.run(),
            Question::Limit(limit) => limit.run(),
            Question::Map(map) => map.run(),
            Question::Paper(paper) => paper.run(),
            Question::Rendering(rendering) => rendering.run(),
            Question::Tune(tune) => tune.run(),
            Question::Bench(bench) => bench.run(),
        }
    }
}

/// Where files go: the folder asked for, or a usual one when the result is for a person.
pub(super) fn folder(out: Option<&Path>, json: bool, usual: &str) -> Option<PathBuf> {
    match (out, json) {
        (None, true) => None,
        (out, _) => Some(out.map_or_else(|| PathBuf::from(usual), Path::to_path_buf)),
    }
}

/// Writes the table beside the picture and names all files.
pub(super) fn write(
    base: &Path,
    table: &Table,
    draw: impl FnOnce() -> Result<Vec<PathBuf>, ReportError>,
) -> Result<Vec<PathBuf>, Failure> {
    // Appended, not replaced: a scene's name may contain a dot.
    let mut csv = base.as_os_str().to_owned();
    csv.push(".csv");
    let csv = PathBuf::from(csv);
    files::write_csv(table, &csv)?;
    let mut written = vec![csv];
    written.extend(draw()?);
    Ok(written)
}

/// Names the files that were written.
pub(super) fn tell(files: &[PathBuf]) {
    for file in files {
        println!("wrote {}", file.display());
    }
}
