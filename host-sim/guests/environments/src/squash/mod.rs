//! Force Feedback Multi-player Squash, played by bots (Buttolo et al. 1997, §3.2.1; `crate::roles::squash`).

pub mod bot;
mod game;
pub mod picture;
mod referee;
mod world;

use rayon::prelude::*;
use serde::Serialize;

pub use bot::MOTION;
pub use game::{Change, Game, Options};
pub use referee::Report;
pub use world::play;

/// Round trips of the table that the bounders are for, ms: the range of issue and paper.
pub const ROUND_TRIPS_MS: [f64; 7] = [10.0, 20.0, 50.0, 100.0, 200.0, 300.0, 400.0];

/// The bounders of the table: name, whether the ball is bounded, whether the hands are.
const BOUNDERS: [(&str, bool, bool); 3] = [("none", false, false), ("ball", true, false), ("ball+motion", true, true)];

/// One game of the table.
#[derive(Serialize)]
pub struct Cell {
    /// Between any two, ms.
    pub round_trip_ms: f64,
    /// Which bounders were on: `none`, `ball` or `ball+motion`.
    pub bounder: &'static str,
    /// What the game came to, as the referee saw it.
    pub report: Report,
}

/// Games over all round trips with all bounders, in parallel; the same on any number of threads.
pub fn sweep(options: &Options) -> Vec<Cell> {
    let cells: Vec<_> = ROUND_TRIPS_MS.iter().flat_map(|ms| BOUNDERS.map(|bounder| (*ms, bounder))).collect();
    let game = |(ms, (name, bounder, motion_bounder))| {
        let options = Options { round_trip_s: ms * 1e-3, bounder, motion_bounder, ..options.clone() };
        Cell { round_trip_ms: ms, bounder: name, report: play(&options).report }
    };
    cells.into_par_iter().map(game).collect()
}
