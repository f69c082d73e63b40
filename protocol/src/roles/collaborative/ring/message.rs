//! What the members of a ring say to each other. All little-endian; the event's code is [`code::RING`].
//!
//! | offset | type | field |
//! |---|---|---|
//! | 0 | u8 | kind: 1 hold, 2 held, 3 pass, 4 elect, 5 vote, 6 newer, 7 join, 8 leave |
//! | 1 | u8 | held: bit 0 wants the token, bit 1 leaves; otherwise 0 |
//! | 2 | u16 | object |
//! | 4 | | hold: ballot, state, number u32. held: ballot, version u32, number u32. pass: ballot, state. elect, newer: epoch u32. vote: epoch u32, ballot, state. join, leave: nothing |
//!
//! A ballot is epoch u32, turn u32; a state is version u32, roster u16, roster before u16, value 24 bytes. Up to 48 bytes.

use super::{Ballot, Roster, State};
use crate::roles::{Carried, code};
use crate::wire::bytes::{Reader, Writer};
use crate::wire::{self, Error, Event};

/// A message about one object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Message {
    /// Holder: I have the token; keep this state, and vote for nobody else for a lease.
    Hold {
        /// The holder's.
        ballot: Ballot,
        /// The object and its members.
        state: State,
        /// 1, 2, 3 … in the order of sending.
        number: u32,
    },
    /// Member: so be it.
    Held {
        /// Of the hold.
        ballot: Ballot,
        /// Of the state that is kept.
        version: u32,
        /// Of the hold.
        number: u32,
        /// It would like to edit.
        wants: bool,
        /// It would like to leave the ring.
        leaves: bool,
    },
    /// Holder: the token is yours.
    Pass {
        /// The next holder's.
        ballot: Ballot,
        /// The object and its members.
        state: State,
    },
    /// Candidate: the token seems to be lost; may I make a new one?
    Elect {
        /// Of the new token; no two candidates have the same.
        epoch: u32,
    },
    /// Member: you may, and this is the newest that I know. I hear no lower epoch from now on.
    Vote {
        /// Of the new token.
        epoch: u32,
        /// Under which the state was kept.
        ballot: Ballot,
        /// The object and its members.
        state: State,
    },
    /// Member: I have promised to hear no epoch below this.
    Newer {
        /// The promise.
        epoch: u32,
    },
    /// Somebody who would like to be a member.
    Join,
    /// A member who would like to leave, and to be told when it has.
    Leave,
}

const BALLOT: usize = 8;
const STATE: usize = 32;

fn ballot(reader: &mut Reader<'_>) -> Result<Ballot, Error> {
    Ok(Ballot { epoch: reader.u32()?, turn: reader.u32()? })
}

fn state(reader: &mut Reader<'_>) -> Result<State, Error> {
    let (version, roster, before) = (reader.u32()?, Roster(reader.u16()?), Roster(reader.u16()?));
    Ok(State { version, roster, before, value: reader.array()? })
}

/// The fields of a message, one after the other.
struct Fields<'a>(Writer<'a>);

impl Fields<'_> {
    fn word(self, word: u32) -> Self {
        Self(self.0.put(&word.to_le_bytes()))
    }

    fn ballot(self, ballot: &Ballot) -> Self {
        self.word(ballot.epoch).word(ballot.turn)
    }

    fn state(self, state: &State) -> Self {
        let Self(writer) = self.word(state.version);
        Self(writer.put(&state.roster.0.to_le_bytes()).put(&state.before.0.to_le_bytes()).put(&state.value))
    }
}

impl Message {
    /// The message as an event about `object`.
    pub fn event(&self, object: u16) -> Result<Event, Error> {
        let mut bytes = [0; Event::MAX_PAYLOAD];
        let (kind, flags) = match self {
            Self::Hold { .. } => (1, 0),
            Self::Held { wants, leaves, .. } => (2, u8::from(*wants) | u8::from(*leaves) << 1),
            Self::Pass { .. } => (3, 0),
            Self::Elect { .. } => (4, 0),
            Self::Vote { .. } => (5, 0),
            Self::Newer { .. } => (6, 0),
            Self::Join => (7, 0),
            Self::Leave => (8, 0),
        };
        let head = Fields(Writer::new(&mut bytes, "ring").put(&[kind, flags]).put(&object.to_le_bytes()));
        let Fields(writer) = match self {
            Self::Hold { ballot, state, number } => head.ballot(ballot).state(state).word(*number),
            Self::Held { ballot, version, number, .. } => head.ballot(ballot).word(*version).word(*number),
            Self::Pass { ballot, state } => head.ballot(ballot).state(state),
            Self::Elect { epoch } | Self::Newer { epoch } => head.word(*epoch),
            Self::Vote { epoch, ballot, state } => head.word(*epoch).ballot(ballot).state(state),
            Self::Join | Self::Leave => head,
        };
        let len = writer.end()?;
        Event::new(code::RING, bytes.get(..len).unwrap_or(&[]))
    }

    /// The object and the message that an event holds.
    pub fn parse(event: &Event) -> Result<(u16, Self), Error> {
        let bytes = event.payload();
        if event.code != code::RING {
            return Err(Error::OutOfRange { message: "ring", field: "code" });
        }
        let (kind, flags) = (bytes.first().copied().unwrap_or(0), bytes.get(1).copied().unwrap_or(0));
        let body = match (kind, flags) {
            (1, 0) => BALLOT + STATE + 4,
            (2, 0..=3) => BALLOT + 8,
            (3, 0) => BALLOT + STATE,
            (4 | 6, 0) => 4,
            (5, 0) => 4 + BALLOT + STATE,
            (7 | 8, 0) => 0,
            (1..=8, _) => return Err(Error::Reserved { message: "ring" }),
            _ => return Err(Error::UnknownKind { kind }),
        };
        let mut reader = Reader::exact(bytes, "ring", 4 + body)?;
        reader.array::<2>()?;
        let object = reader.u16()?;
        let message = match kind {
            1 => Self::Hold { ballot: ballot(&mut reader)?, state: state(&mut reader)?, number: reader.u32()? },
            2 => Self::Held {
                ballot: ballot(&mut reader)?,
                version: reader.u32()?,
                number: reader.u32()?,
                wants: flags & 1 != 0,
                leaves: flags & 2 != 0,
            },
            3 => Self::Pass { ballot: ballot(&mut reader)?, state: state(&mut reader)? },
            4 => Self::Elect { epoch: reader.u32()? },
            5 => Self::Vote { epoch: reader.u32()?, ballot: ballot(&mut reader)?, state: state(&mut reader)? },
            6 => Self::Newer { epoch: reader.u32()? },
            7 => Self::Join,
            _ => Self::Leave,
        };
        reader.end()?;
        Ok((object, message))
    }
}

impl Carried for Message {
    fn carry(&self, object: u16) -> Result<wire::Message, Error> {
        self.event(object).map(wire::Message::Event)
    }

    fn read(message: &wire::Message) -> Option<(u16, Self)> {
        let wire::Message::Event(event) = message else { return None };
        Self::parse(event).ok()
    }
}
