//! `host-sim stability`: verdicts, limits and regions, from the code that flies.

mod bench;
mod limit;
mod map;
mod paper;
mod point;

use clap::{Args, Subcommand};

use super::{Failure, Ui};

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
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        match &self.question {
            Question::Point(point) => point.run(ui),
            Question::Limit(limit) => limit.run(ui),
            Question::Map(map) => map.run(ui),
            Question::Paper(paper) => paper.run(ui),
            Question::Rendering(rendering) => rendering.run(ui),
            Question::Tune(tune) => tune.run(ui),
            Question::Bench(bench) => bench.run(ui),
        }
    }
}
