//! A game: what is to be played, and what was.

use cohold_sim::scene::Network;

use super::referee::Report;
use crate::roles::squash::Ball;

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

/// Settings of a game.
#[derive(Clone, Debug)]
pub struct Options {
    /// Number of players, 2 to 8.
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
    /// Seed of all random numbers.
    pub seed: u64,
    /// Who goes and comes, when (s), by number.
    pub changes: Vec<(f64, u8, Change)>,
    /// Keep what happened every so many ticks, for pictures; 0 keeps nothing.
    pub record_every: u64,
}

/// One moment of a game.
pub(super) struct Moment {
    /// True time of the moment, s.
    pub(super) time_s: f64,
    /// Where each player thinks that the ball is.
    pub(super) balls: Vec<Option<Ball>>,
    /// Where each player is.
    pub(super) hands: Vec<[f64; 2]>,
    /// Who may hit, by its own account.
    pub(super) active: Option<usize>,
    /// The newest rally and hit that anybody knows.
    pub(super) turn: (u16, u16),
}

/// A game that was played.
pub struct Game {
    /// The referee's report of the game.
    pub report: Report,
    /// What happened, if it was recorded.
    pub(super) moments: Vec<Moment>,
}
