//! What clients and server of a lock say to each other. All little-endian; the event's code is [`code::LOCK`].
//!
//! | offset | type | field |
//! |---|---|---|
//! | 0 | u8 | kind: 1 follow, 2 ask, 3 release, 4 grant, 5 state, 6 answer |
//! | 1 | u8 | release: 1 if a value follows; answer: 1 if the release was taken; otherwise 0 |
//! | 2 | u16 | object |
//! | 4 | | follow: known u32. ask: incarnation, number, known u32. release: fence u32, value if any. grant: incarnation, number, fence, version u32, value. state: version u32, value. answer: fence u32 |

use super::Copy;
use crate::roles::collaborative::Value;
use crate::roles::{Carried, code};
use crate::wire::bytes::{Reader, Writer};
use crate::wire::{self, Error, Event};

/// A message about one object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Message {
    /// Client: tell me when there is something newer than this version.
    Follow {
        /// Version the client has.
        known: u32,
    },
    /// Client: I want to edit, or go on editing.
    Ask {
        /// Which life of the client.
        incarnation: u32,
        /// 1, 2, 3 … in the order of sending.
        number: u32,
        /// Version the client has.
        known: u32,
    },
    /// Client: I have finished; with fence 0, I no longer want to.
    Release {
        /// Of the grant.
        fence: u32,
        /// What the object is now, if the client has changed it.
        value: Option<Value>,
    },
    /// Server: it is yours, as of the ask that it answers.
    Grant {
        /// Which life of the client.
        incarnation: u32,
        /// Of the ask.
        number: u32,
        /// Number of this grant: higher than that of any before.
        fence: u32,
        /// What there is to edit.
        copy: Copy,
    },
    /// Server: the object as it is.
    State {
        /// The official copy.
        copy: Copy,
    },
    /// Server: what became of a release.
    Answer {
        /// Of the release.
        fence: u32,
        /// The value was taken.
        taken: bool,
    },
}

fn word(writer: Writer<'_>, word: u32) -> Writer<'_> {
    writer.put(&word.to_le_bytes())
}

impl Message {
    /// The message as an event about `object`.
    pub fn event(&self, object: u16) -> Result<Event, Error> {
        let mut bytes = [0; Event::MAX_PAYLOAD];
        let (kind, flag) = match self {
            Self::Follow { .. } => (1, 0),
            Self::Ask { .. } => (2, 0),
            Self::Release { value, .. } => (3, u8::from(value.is_some())),
            Self::Grant { .. } => (4, 0),
            Self::State { .. } => (5, 0),
            Self::Answer { taken, .. } => (6, u8::from(*taken)),
        };
        let head = Writer::new(&mut bytes, "lock").put(&[kind, flag]).put(&object.to_le_bytes());
        let len = match self {
            Self::Follow { known } => word(head, *known),
            Self::Ask { incarnation, number, known } => word(word(word(head, *incarnation), *number), *known),
            Self::Release { fence, value } => word(head, *fence).put(value.as_ref().map_or(&[], |value| value)),
            Self::Grant { incarnation, number, fence, copy } => {
                word(word(word(word(head, *incarnation), *number), *fence), copy.version).put(&copy.value)
            }
            Self::State { copy } => word(head, copy.version).put(&copy.value),
            Self::Answer { fence, .. } => word(head, *fence),
        }
        .end()?;
        Event::new(code::LOCK, bytes.get(..len).unwrap_or(&[]))
    }

    /// The object and the message that an event holds.
    pub fn parse(event: &Event) -> Result<(u16, Self), Error> {
        let bytes = event.payload();
        if event.code != code::LOCK {
            return Err(Error::OutOfRange { message: "lock", field: "code" });
        }
        let (kind, flag) = (bytes.first().copied().unwrap_or(0), bytes.get(1).copied().unwrap_or(0));
        let value = size_of::<Value>();
        let body = match (kind, flag) {
            (1, 0) | (3, 0) | (6, 0 | 1) => 4,
            (2, 0) => 12,
            (3, 1) | (5, 0) => 4 + value,
            (4, 0) => 16 + value,
            (1..=6, _) => return Err(Error::Reserved { message: "lock" }),
            _ => return Err(Error::UnknownKind { kind }),
        };
        let mut reader = Reader::exact(bytes, "lock", 4 + body)?;
        reader.array::<2>()?;
        let object = reader.u16()?;
        let message = match kind {
            1 => Self::Follow { known: reader.u32()? },
            2 => Self::Ask { incarnation: reader.u32()?, number: reader.u32()?, known: reader.u32()? },
            3 => Self::Release { fence: reader.u32()?, value: (flag == 1).then(|| reader.array()).transpose()? },
            4 => Self::Grant {
                incarnation: reader.u32()?,
                number: reader.u32()?,
                fence: reader.u32()?,
                copy: Copy { version: reader.u32()?, value: reader.array()? },
            },
            5 => Self::State { copy: Copy { version: reader.u32()?, value: reader.array()? } },
            _ => Self::Answer { fence: reader.u32()?, taken: flag == 1 },
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
