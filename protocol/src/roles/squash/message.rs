//! What players and server of a game say to each other; the event's code is [`code::SQUASH`]. Times are µs on the clock of who wrote
//! them first, in a hit on the server's.

use super::court::Ball;
use super::rules::{Ending, Game, Turn};
use crate::bytes::messages;
use crate::error::Error;
use crate::roles::{Carried, code};
use crate::wire::{self, Event, Sample};

messages! {
    /// A message of the game.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub enum Message("squash", code::SQUASH, about 0) {
        /// Player: I would like to play.
        Join = 1, 4 bytes
        /// Player: I stop.
        Leave = 2, 4 bytes
        /// Server: the game as it stands.
        Game = 3, 32 bytes {
            /// All of it.
            1 => game: Game,
        }
        /// Player, every 50 ms: where I am, and what I know. Newest wins.
        Place = 4, 34 bytes {
            /// The newest hit that is known.
            2 => turn: Turn,
            /// The newest state of the game that is known.
            6 => revision: u16,
            /// Which life of the player.
            8 => life: u16,
            /// 1, 2, 3 … in the order of sending.
            10 => number: u32,
            /// The longest round trip that was measured to anybody, µs.
            14 => round_trip_us: u32,
            /// The racket: position and velocity.
            18 => racket: Ball,
        }
        /// Active player: I have hit the ball.
        Hit = 5, 32 bytes {
            /// Which hit.
            2 => turn: Turn,
            /// When, µs on the server's clock.
            8 => at_us: u64,
            /// The ball just after.
            16 => ball: Ball,
        }
        /// Active player: the ball is lost.
        Miss = 6, 8 bytes {
            /// Why.
            1 => ending: Ending,
            /// The hit that was not returned.
            2 => turn: Turn,
        }
        /// Anybody: how far away are you, and what time is it there?
        Ping = 7, 16 bytes {
            /// 1, 2, 3 …
            4 => number: u32,
            /// When it was sent first, µs.
            8 => sent_us: u64,
        }
        /// The answer.
        Pong = 8, 32 bytes {
            /// Of the ping.
            4 => number: u32,
            /// Of the ping.
            8 => sent_us: u64,
            /// When it came, µs.
            16 => received_us: u64,
            /// When it was answered, µs.
            24 => answered_us: u64,
        }
    }
}

/// Single events (join, leave, hit, miss) are to arrive; the rest is flow, of which the newest counts. There is one game, and its
/// messages name no object.
impl Carried for Message {
    fn carry(&self, object: u16) -> Result<wire::Message, Error> {
        let event = self.event(object)?;
        Ok(match self {
            Self::Join | Self::Leave | Self::Hit { .. } | Self::Miss { .. } => wire::Message::Event(event),
            _ => wire::Message::Sample(Sample::new(event.code, event.payload())?),
        })
    }

    fn read(message: &wire::Message) -> Option<(u16, Self)> {
        match message {
            wire::Message::Event(event) => Self::parse(event).ok(),
            wire::Message::Sample(sample) => Self::parse(&Event::new(sample.code, sample.payload()).ok()?).ok(),
            _ => None,
        }
    }
}
