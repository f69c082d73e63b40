//! What players and server of a game say to each other. All little-endian; the event's code is [`code::SQUASH`].
//!
//! | offset | type | field |
//! |---|---|---|
//! | 0 | u8 | kind: 1 join, 2 leave, 3 game, 4 place, 5 hit, 6 miss, 7 ping, 8 pong |
//! | 1 | u8 | game: phase; miss: reason; otherwise 0 |
//! | 2 | | join, leave: u16 0. game: rally, revision u16, players u8 × 8 (0 is none), longest round trip u32, result: rally, strokes u16, ending, loser u8, score u8 × 8. place: rally, stroke, revision, life u16, number, round trip u32, ball f32 × 4. hit: rally, stroke, u16 0, time u64, ball f32 × 4. miss: rally, stroke, u16 0. ping: u16 0, number u32, time u64. pong: u16 0, number u32, times u64 × 3 |
//!
//! A ball is position and velocity, m and m/s, every number finite; times are µs on the clock of who wrote them first, in a hit
//! on the server's. Up to 34 bytes.

use super::{Ball, Ending, Game, PLAYERS, Phase, Turn, Verdict};
use crate::roles::{Carried, code};
use crate::wire::bytes::{Reader, Writer};
use crate::wire::{self, Error, Event, PeerId, Sample};

/// A message of the game.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Message {
    /// Player: I would like to play.
    Join,
    /// Player: I stop.
    Leave,
    /// Server: the game as it stands.
    Game(Game),
    /// Player, every 50 ms: where I am, and what I know. Newest wins.
    Place {
        /// The newest hit that is known.
        turn: Turn,
        /// The newest state of the game that is known.
        revision: u16,
        /// Which life of the player.
        life: u16,
        /// 1, 2, 3 … in the order of sending.
        number: u32,
        /// The longest round trip that was measured to anybody, µs.
        round_trip_us: u32,
        /// The racket: position and velocity.
        racket: Ball,
    },
    /// Active player: I have hit the ball.
    Hit {
        /// Which hit.
        turn: Turn,
        /// When, µs on the server's clock.
        at_us: u64,
        /// The ball just after.
        ball: Ball,
    },
    /// Active player: the ball is lost.
    Miss {
        /// The hit that was not returned.
        turn: Turn,
        /// Why.
        ending: Ending,
    },
    /// Anybody: how far away are you, and what time is it there?
    Ping {
        /// 1, 2, 3 …
        number: u32,
        /// When it was sent first, µs.
        sent_us: u64,
    },
    /// The answer.
    Pong {
        /// Of the ping.
        number: u32,
        /// Of the ping.
        sent_us: u64,
        /// When it came, µs.
        received_us: u64,
        /// When it was answered, µs.
        answered_us: u64,
    },
}

fn ball(reader: &mut Reader<'_>) -> Result<Ball, Error> {
    Ok(Ball { position: [reader.f32()?, reader.f32()?], velocity: [reader.f32()?, reader.f32()?] })
}

fn turn(reader: &mut Reader<'_>) -> Result<Turn, Error> {
    Ok(Turn { rally: reader.u16()?, stroke: reader.u16()? })
}

/// The fields of a message, one after the other.
struct Fields<'a>(Writer<'a>);

impl Fields<'_> {
    fn bytes(self, bytes: &[u8]) -> Self {
        Self(self.0.put(bytes))
    }

    fn half(self, half: u16) -> Self {
        self.bytes(&half.to_le_bytes())
    }

    fn word(self, word: u32) -> Self {
        self.bytes(&word.to_le_bytes())
    }

    fn long(self, long: u64) -> Self {
        self.bytes(&long.to_le_bytes())
    }

    fn turn(self, turn: Turn) -> Self {
        self.half(turn.rally).half(turn.stroke)
    }

    fn ball(self, ball: &Ball) -> Self {
        let ([x, y], [vx, vy]) = (ball.position, ball.velocity);
        Self(self.0.f32(x).f32(y).f32(vx).f32(vy))
    }
}

impl Message {
    /// The message as an event.
    pub fn event(&self) -> Result<Event, Error> {
        let mut bytes = [0; Event::MAX_PAYLOAD];
        let (kind, flag) = match self {
            Self::Join => (1, 0),
            Self::Leave => (2, 0),
            Self::Game(game) => (3, game.phase as u8),
            Self::Place { .. } => (4, 0),
            Self::Hit { .. } => (5, 0),
            Self::Miss { ending, .. } => (6, *ending as u8),
            Self::Ping { .. } => (7, 0),
            Self::Pong { .. } => (8, 0),
        };
        let head = Fields(Writer::new(&mut bytes, "squash").put(&[kind, flag]));
        let Fields(writer) = match self {
            Self::Join | Self::Leave => head.half(0),
            Self::Game(game) => head
                .half(game.rally)
                .half(game.revision)
                .bytes(&game.players.map(|player| player.0))
                .word(game.round_trip_us)
                .half(game.last.rally)
                .half(game.last.strokes)
                .bytes(&[game.last.ending as u8, game.last.loser.0])
                .bytes(&game.score),
            Self::Place { turn, revision, life, number, round_trip_us, racket } => {
                head.turn(*turn).half(*revision).half(*life).word(*number).word(*round_trip_us).ball(racket)
            }
            Self::Hit { turn, at_us, ball } => head.turn(*turn).half(0).long(*at_us).ball(ball),
            Self::Miss { turn, .. } => head.turn(*turn).half(0),
            Self::Ping { number, sent_us } => head.half(0).word(*number).long(*sent_us),
            Self::Pong { number, sent_us, received_us, answered_us } => {
                head.half(0).word(*number).long(*sent_us).long(*received_us).long(*answered_us)
            }
        };
        let len = writer.end()?;
        Event::new(code::SQUASH, bytes.get(..len).unwrap_or(&[]))
    }

    /// The message that an event holds.
    pub fn parse(event: &Event) -> Result<Self, Error> {
        let bytes = event.payload();
        if event.code != code::SQUASH {
            return Err(Error::OutOfRange { message: "squash", field: "code" });
        }
        let (kind, flag) = (bytes.first().copied().unwrap_or(0), bytes.get(1).copied().unwrap_or(0));
        let body = match kind {
            1 | 2 => 2,
            3 => 14 + 2 * PLAYERS,
            4 => 32,
            5 | 8 => 30,
            6 => 6,
            7 => 14,
            _ => return Err(Error::UnknownKind { kind }),
        };
        let mut reader = Reader::exact(bytes, "squash", 2 + body)?;
        reader.array::<2>()?;
        if flag != 0 && kind != 3 && kind != 6 {
            return Err(Error::Reserved { message: "squash" });
        }
        let message = match kind {
            1 | 2 => {
                reader.reserved::<2>()?;
                if kind == 1 { Self::Join } else { Self::Leave }
            }
            3 => Self::Game(Game {
                phase: Phase::from_byte(flag)?,
                rally: reader.u16()?,
                revision: reader.u16()?,
                players: reader.array::<PLAYERS>()?.map(PeerId),
                round_trip_us: reader.u32()?,
                last: Verdict {
                    rally: reader.u16()?,
                    strokes: reader.u16()?,
                    ending: Ending::from_byte(reader.u8()?)?,
                    loser: PeerId(reader.u8()?),
                },
                score: reader.array()?,
            }),
            4 => Self::Place {
                turn: turn(&mut reader)?,
                revision: reader.u16()?,
                life: reader.u16()?,
                number: reader.u32()?,
                round_trip_us: reader.u32()?,
                racket: ball(&mut reader)?,
            },
            5 => {
                let turn = turn(&mut reader)?;
                reader.reserved::<2>()?;
                Self::Hit { turn, at_us: reader.u64()?, ball: ball(&mut reader)? }
            }
            6 => {
                let turn = turn(&mut reader)?;
                reader.reserved::<2>()?;
                Self::Miss { turn, ending: Ending::from_byte(flag)? }
            }
            _ => {
                reader.reserved::<2>()?;
                let (number, sent_us) = (reader.u32()?, reader.u64()?);
                if kind == 7 {
                    Self::Ping { number, sent_us }
                } else {
                    Self::Pong { number, sent_us, received_us: reader.u64()?, answered_us: reader.u64()? }
                }
            }
        };
        reader.end()?;
        Ok(message)
    }
}

/// Single events (join, leave, hit, miss) are to arrive; the rest is flow, of which the newest counts. There is one game, and its
/// messages name no object.
impl Carried for Message {
    fn carry(&self, _: u16) -> Result<wire::Message, Error> {
        let event = self.event()?;
        Ok(match self {
            Self::Join | Self::Leave | Self::Hit { .. } | Self::Miss { .. } => wire::Message::Event(event),
            _ => wire::Message::Sample(Sample::new(event.code, event.payload())?),
        })
    }

    fn read(message: &wire::Message) -> Option<(u16, Self)> {
        let said = match message {
            wire::Message::Event(event) => Self::parse(event),
            wire::Message::Sample(sample) => {
                Event::new(sample.code, sample.payload()).and_then(|event| Self::parse(&event))
            }
            _ => return None,
        };
        Some((0, said.ok()?))
    }
}
