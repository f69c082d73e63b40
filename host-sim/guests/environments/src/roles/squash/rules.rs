//! Rules of the game: how many play, the state of the game that the server has, and what is said how often.

use cohold_protocol::bytes::{byte_enum, layout};
use cohold_protocol::wire::PeerId;

use super::ball::Ball;
use crate::roles::messages::messages;

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
    /// A hit's place in the game: its rally, and its stroke there. Stroke 0 is before the serve, 1 is the serve.
    #[derive(Eq, PartialOrd, Ord)]
    pub struct Turn(4 bytes) {
        0 => rally: u16, "1, 2, 3 …";
        2 => stroke: u16, "How often the ball has been hit.";
    }
}

byte_enum! {
    /// What the server is doing.
    pub enum Phase("phase") {
        0 => Waiting, "Players come; or all are told how the last rally ended.";
        1 => Rally, "A rally.";
        2 => Over, "The game is over.";
    }
}

byte_enum! {
    /// How a rally ended.
    pub enum Ending("ending") {
        0 => None, "Nothing has ended yet.";
        1 => Missed, "The active player did not hit the ball before it left the court: a point for who hit it last.";
        2 => Fault, "The active player did not send the ball to the front: a point for who hit it before.";
        3 => Unseen,
            "The ball had left the court before the active player knew that it was hit: played again. A bounder is \
             there to make this impossible.";
        4 => Broken, "A player has left or was no longer heard: played again.";
    }
}

impl Ending {
    /// Whether the rally gives somebody a point.
    pub fn scores(self) -> bool {
        matches!(self, Self::Missed | Self::Fault)
    }
}

layout! {
    /// What a rally came to.
    pub struct Verdict(6 bytes) {
        0 => rally: u16, "Which rally; 0 while there was none.";
        2 => strokes: u16, "Hits.";
        4 => ending: Ending, "How it ended.";
        5 => loser: PeerId, "Who was active then.";
    }
}

layout! {
    /// The game as the server has it; a higher revision is newer.
    pub struct Game(31 bytes) {
        0 => phase: Phase, "What the server is doing.";
        1 => rally: u16, "The rally that is on, or the last one.";
        3 => revision: u16, "1, 2, 3 … with every change but that of the round trip.";
        5 => players: [PeerId; PLAYERS],
            "The players in the order in which they hit; the first one serves. 0 is nobody.";
        13 => round_trip_us: u32, "The longest round trip between any two, µs; 0 is no bound.";
        17 => last: Verdict, "What the last rally came to.";
        23 => score: [u8; PLAYERS], "Points of player 1, 2, 3 …";
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

messages! {
    /// What players and server say to each other. Times are µs on the clock of who wrote them first, in a hit on the server's.
    pub enum Message("squash", code 0x0103, about 0, flow Game Place Ping Pong) {
        /// Player: I would like to play.
        Join = 1, 4 bytes
        /// Player: I stop playing.
        Leave = 2, 4 bytes
        /// Server: the game as it stands.
        Game = 3, 32 bytes:
            1 => game: Game, "All of it.";
        /// Player, every 50 ms: where I am, and what I know. Newest wins.
        Place = 4, 34 bytes:
            2 => turn: Turn, "The newest hit that is known.";
            6 => revision: u16, "The newest state of the game that is known.";
            8 => life: u16, "Which life of the player.";
            10 => number: u32, "1, 2, 3 … in the order of sending.";
            14 => round_trip_us: u32, "The longest round trip that was measured to anybody, µs.";
            18 => racket: Ball, "The racket: position and velocity.";
        /// Active player: I have hit the ball.
        Hit = 5, 32 bytes:
            2 => turn: Turn, "Which hit.";
            8 => at_us: u64, "When, µs on the server's clock.";
            16 => ball: Ball, "The ball just after.";
        /// Active player: the ball is lost.
        Miss = 6, 8 bytes:
            1 => ending: Ending, "Why.";
            2 => turn: Turn, "The hit that was not returned.";
        /// Anybody: how far away are you, and what time is it there?
        Ping = 7, 16 bytes:
            4 => number: u32, "1, 2, 3 …";
            8 => sent_us: u64, "When it was sent first, µs.";
        /// Anybody: the answer to a ping.
        Pong = 8, 32 bytes:
            4 => number: u32, "Of the ping.";
            8 => sent_us: u64, "Of the ping.";
            16 => received_us: u64, "When it came, µs.";
            24 => answered_us: u64, "When it was answered, µs.";
    }
}
