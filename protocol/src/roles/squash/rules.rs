//! Rules of the game: how many play, what is said how often, and the state of the game that the server has.

use crate::bytes::{byte_enum, layout};
use crate::wire::PeerId;

/// Players that a game can have.
pub const PLAYERS: usize = 8;
/// Rallies that a game can have: each takes two of the 65,535 revisions of [`Game::revision`].
pub const RALLIES: u16 = 32_767;
/// How often a player says where it is, µs.
pub const PLACE_EVERY_US: u64 = 50_000;
/// How soon something is said again that nobody has answered, µs.
pub const SAY_AGAIN_US: u64 = 25_000;
/// How often a round trip is measured, to each other peer, µs.
pub const PING_EVERY_US: u64 = 250_000;
/// Silence after which a player is out, µs.
pub const HEARTBEAT_LIMIT_US: u64 = 1_500_000;

/// The server's number; players are 1 to [`PLAYERS`].
pub const SERVER: PeerId = PeerId(0);

layout! {
    /// Which hit of which rally. Stroke 0 is before the serve, 1 is the serve.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
    pub struct Turn(4 bytes) {
        /// 1, 2, 3 …
        0 => rally: u16,
        /// How often the ball has been hit.
        2 => stroke: u16,
    }
}

byte_enum! {
    /// What the server is doing.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Phase("phase") {
        /// Players come; or all are told how the last rally ended.
        #[default]
        Waiting = 0,
        /// A rally.
        Rally = 1,
        /// The game is over.
        Over = 2,
    }
}

byte_enum! {
    /// How a rally ended.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Ending("ending") {
        /// Nothing has ended yet.
        #[default]
        None = 0,
        /// The active player did not hit the ball before it left the court: a point for who hit it last.
        Missed = 1,
        /// The active player did not send the ball to the front: a point for who hit it before.
        Fault = 2,
        /// The ball had left the court before the active player knew that it was hit: played again. A bounder is there to
        /// make this impossible.
        Unseen = 3,
        /// A player has left or was no longer heard: played again.
        Broken = 4,
    }
}

impl Ending {
    /// Whether somebody scores.
    pub fn scores(self) -> bool {
        matches!(self, Self::Missed | Self::Fault)
    }
}

layout! {
    /// What a rally came to.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct Verdict(6 bytes) {
        /// Which rally; 0 while there was none.
        0 => rally: u16,
        /// Hits.
        2 => strokes: u16,
        /// How it ended.
        4 => ending: Ending,
        /// Who was active then.
        5 => loser: PeerId,
    }
}

layout! {
    /// The game as the server has it; a higher revision is newer.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct Game(31 bytes) {
        /// What the server is doing.
        0 => phase: Phase,
        /// The rally that is on, or the last one.
        1 => rally: u16,
        /// 1, 2, 3 … with every change but that of the round trip.
        3 => revision: u16,
        /// The players in the order in which they hit; the first one serves. 0 is nobody.
        5 => players: [PeerId; PLAYERS],
        /// The longest round trip between any two, µs; 0 is no bound.
        13 => round_trip_us: u32,
        /// What the last rally came to.
        17 => last: Verdict,
        /// Points of player 1, 2, 3 …
        23 => score: [u8; PLAYERS],
    }
}

impl Game {
    /// The players, in order.
    pub fn order(&self) -> impl Iterator<Item = PeerId> + use<> {
        self.players.into_iter().filter(|player| *player != SERVER)
    }

    /// Who may make the next hit, after so many.
    pub fn active(&self, strokes: u16) -> Option<PeerId> {
        let at = usize::from(strokes).checked_rem(self.order().count())?;
        self.order().nth(at)
    }
}

/// Where in a table a player is.
pub(super) fn place_of(player: PeerId) -> usize {
    usize::from(player.0).wrapping_sub(1)
}
