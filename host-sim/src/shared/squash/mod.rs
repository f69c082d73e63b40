//! Force Feedback Multi-player Squash, played by bots (Buttolo et al. 1997, §3.2.1; `haptic_protocol::roles::squash`).

pub(crate) mod bot;
pub(crate) mod picture;
mod referee;
mod world;

use haptic_protocol::roles::squash::Ball;
use haptic_sim::scene::Network;
use rayon::prelude::*;
use serde::Serialize;

pub use bot::MOTION;
pub use referee::Report;
pub use world::play;

/// Somebody goes or comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// Says that it leaves.
    Leaves,
    /// Is switched off without a word.
    Vanishes,
    /// Is switched on, and knows nothing.
    Comes,
}

/// What to play.
#[derive(Clone, Debug)]
pub struct Options {
    /// 2 to 8.
    pub players: u8,
    /// Between any two, s; the network may add to it.
    pub round_trip_s: f64,
    /// What else the network does.
    pub network: Network,
    /// The ball is bounded by the round trip.
    pub bounder: bool,
    /// The hands are damped by the round trip.
    pub motion_bounder: bool,
    /// Longest simulated time, s.
    pub seconds: f64,
    /// Rallies after which the game is over.
    pub rallies: u16,
    /// Of everything random.
    pub seed: u64,
    /// Who goes and comes, when (s), by number.
    pub changes: Vec<(f64, u8, Change)>,
    /// Keep what happened every so many ticks, for pictures; 0 keeps nothing.
    pub record_every: u64,
}

/// One moment of a game.
struct Moment {
    /// True time, s.
    time_s: f64,
    /// Where each player thinks that the ball is.
    balls: Vec<Option<Ball>>,
    /// Where each player is.
    hands: Vec<[f64; 2]>,
    /// Who may hit, by its own account.
    active: Option<usize>,
    /// Which rally, and hit, by the newest that anybody knows.
    turn: (u16, u16),
}

/// A game that was played.
pub struct Game {
    /// What it came to.
    pub report: Report,
    /// What happened, if it was recorded.
    moments: Vec<Moment>,
}

/// Round trips of the table that the bounders are for, ms: the range of issue and paper.
pub const ROUND_TRIPS_MS: [f64; 7] = [10.0, 20.0, 50.0, 100.0, 200.0, 300.0, 400.0];

/// Which bounders: name, the ball's, the hands'.
const BOUNDERS: [(&str, bool, bool); 3] = [("none", false, false), ("ball", true, false), ("ball+motion", true, true)];

/// One game of the table.
#[derive(Serialize)]
pub(crate) struct Cell {
    /// Between any two, ms.
    pub(crate) round_trip_ms: f64,
    pub(crate) bounder: &'static str,
    pub(crate) report: Report,
}

/// Games over all round trips with all bounders, in parallel; the same on any number of threads.
pub(crate) fn sweep(options: &Options) -> Vec<Cell> {
    let cells: Vec<_> = ROUND_TRIPS_MS.iter().flat_map(|ms| BOUNDERS.map(|bounder| (*ms, bounder))).collect();
    let game = |(ms, (name, bounder, motion_bounder))| {
        let options = Options { round_trip_s: ms * 1e-3, bounder, motion_bounder, ..options.clone() };
        Cell { round_trip_ms: ms, bounder: name, report: play(&options).report }
    };
    cells.into_par_iter().map(game).collect()
}
