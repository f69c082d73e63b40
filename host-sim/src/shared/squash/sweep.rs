//! The table that the bounders are for: games over round trips, without a bound, with the ball's, with both.

use rayon::prelude::*;
use serde::Serialize;

use super::{Options, Report, play};

/// Round trips, ms: the range of issue and paper.
pub const ROUND_TRIPS_MS: [f64; 7] = [10.0, 20.0, 50.0, 100.0, 200.0, 300.0, 400.0];

/// Which bounders: name, the ball's, the hands'.
pub const BOUNDERS: [(&str, bool, bool); 3] =
    [("none", false, false), ("ball", true, false), ("ball+motion", true, true)];

/// One game of the table.
#[derive(Clone, Debug, Serialize)]
pub struct Cell {
    /// Between any two, ms.
    pub round_trip_ms: f64,
    /// Which bounders.
    pub bounder: &'static str,
    /// What the game came to.
    pub report: Report,
}

/// Plays all of them, in parallel; the same on any number of threads.
pub fn sweep(options: &Options) -> Vec<Cell> {
    let cells: Vec<_> =
        ROUND_TRIPS_MS.iter().flat_map(|ms| BOUNDERS.iter().map(move |bounder| (*ms, *bounder))).collect();
    cells
        .into_par_iter()
        .map(|(ms, (name, bounder, motion_bounder))| {
            let options = Options { round_trip_s: ms * 1e-3, bounder, motion_bounder, ..options.clone() };
            Cell { round_trip_ms: ms, bounder: name, report: play(&options).report }
        })
        .collect()
}
