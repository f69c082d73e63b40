//! Force Feedback Multi-player Squash: 2 to 8 players, one ball, one at a time may hit it (Buttolo et al. 1997, §3.2.1).
//!
//! ```text
//!            join, leave, start, result, longest round trip
//! Server ◄────────────────────────────────────────────────► Player ◄──── place every 50 ms, hit ────► Player
//! ```
//!
//! | who | decides | how the others know |
//! |---|---|---|
//! | active player: the next in order after each hit | whether the ball is hit, and where it flies then; whether it is lost | hit, said again until each says that it knows |
//! | server | who plays, in which order; when a rally begins; what it came to; the score; the bound on speed | its state of the game, newest wins, said again all the time |
//! | everybody | where the ball is between hits: dead reckoning on the server's time ([`Court::flight`]) | |
//!
//! The active player's right is a token: it goes with the number of the hit ([`Turn`]), and what is said about an earlier one
//! changes nothing. A result counts when the server says so, and the next rally begins when every player has said that it
//! knows the last one. So all agree on every rally, whatever is lost or late on the way; a player who is silent for
//! [`HEARTBEAT_LIMIT_US`] is out, and the rally is played again.
//!
//! | message | how often |
//! |---|---|
//! | place | every [`PLACE_EVERY_US`], to all: the heartbeat, and the acknowledgement of everything |
//! | hit, miss, ping | every [`SAY_AGAIN_US`] until answered: a loss costs that, and not a round trip |
//! | game | every [`PLACE_EVERY_US`], and at every change |
//!
//! Round trips are counted from the first sending, so that what is lost counts as late: the bound on the ball ([`BallBounds`])
//! is for the network as it is.
//!
//! **Limits**: a delay that jumps is known only when somebody has measured it ([`PING_EVERY_US`] and a round trip later): a ball that
//! was hit in between may leave the court unseen, and the rally is played again. Plan view, no gravity; who stands in the
//! ball's way is not hit. A game has up to [`RALLIES`] rallies, a rally up to 65,535 strokes; points stop at 255. The server's
//! word is the game's: it ends with it.

mod bounder;
mod court;
mod message;
mod player;
mod server;
mod stroke;

pub use bounder::{BallBounds, MotionBounder, RoundTrips};
pub use court::{Ball, Court};
pub use message::Message;
pub use player::{Notice, Player, PlayerConfig, Strike};
pub use server::{Server, ServerConfig};
pub use stroke::{Impact, Racket};

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
fn place_of(player: PeerId) -> usize {
    usize::from(player.0).wrapping_sub(1)
}
