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

mod ball;
mod player;
mod rules;
mod server;

pub use ball::{Ball, BallBounds, Court, Impact, MotionBounder, Racket, RoundTrips};
pub use player::{Notice, Player, PlayerConfig, Strike};
pub use rules::{
    Ending, Game, HEARTBEAT_LIMIT_US, Message, PING_EVERY_US, PLACE_EVERY_US, PLAYERS, Phase, RALLIES, SAY_AGAIN_US,
    SERVER, Turn, Verdict,
};
pub use server::{Server, ServerConfig};
