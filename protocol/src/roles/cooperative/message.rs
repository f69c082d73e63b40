//! Who has the engine: what server and clients say to each other. All little-endian; the event's code is
//! [`code::COOPERATIVE`].
//!
//! | offset | type | field |
//! |---|---|---|
//! | 0 | u8 | kind: 1 ask, 2 lend, 3 renew, 4 renewed, 5 recall, 6 return, 7 taken |
//! | 1 | u8 | 0 |
//! | 2 | u16 | object |
//! | 4 | u32 | version of the engine; ask: 0 |
//! | 8 | u64 | ask, lend, renew, renewed: stamp, µs of the client's clock |
//! | 8 or 16 | f64 × 4 | lend, return: x, ẋ, y, ẏ of the object, m and m/s, exact |

use crate::roles::{Carried, code};
use crate::wire::bytes::{Reader, Writer};
use crate::wire::{self, Error, Event};

/// Motion of the object along two axes as it is handed over: position (m) and velocity (m/s).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Body {
    /// Along x and y.
    pub axes: [[f64; 2]; 2],
}

/// Who has the engine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Message {
    /// Client: I want it.
    Ask {
        /// Now, on the client's clock.
        stamp_us: u64,
    },
    /// Server: it is yours, go on from here.
    Lend {
        /// Of the engine from now on.
        version: u32,
        /// As the request had it.
        stamp_us: u64,
        /// Where the object is.
        body: Body,
    },
    /// Client: I still have it.
    Renew {
        /// Of the engine.
        version: u32,
        /// Now, on the client's clock.
        stamp_us: u64,
    },
    /// Server: keep it.
    Renewed {
        /// Of the engine.
        version: u32,
        /// As the request had it.
        stamp_us: u64,
    },
    /// Server: give it back.
    Recall {
        /// Of the engine.
        version: u32,
    },
    /// Client: it is yours again, go on from here.
    Return {
        /// Of the engine until now.
        version: u32,
        /// Where the object is.
        body: Body,
    },
    /// Server: it is back.
    Taken {
        /// Of the engine that was returned.
        version: u32,
    },
}

/// Bytes before what only some messages have, of a stamp and of a body.
const HEAD: usize = 8;
const STAMP: usize = 8;
const BODY: usize = 32;

fn body(reader: &mut Reader<'_>) -> Result<Body, Error> {
    let mut body = Body::default();
    for number in body.axes.iter_mut().flatten() {
        *number = reader.f64()?;
    }
    Ok(body)
}

impl Message {
    /// The message as an event about `object`.
    pub fn event(&self, object: u16) -> Result<Event, Error> {
        let (kind, version, stamp, body) = match *self {
            Self::Ask { stamp_us } => (1, 0, Some(stamp_us), None),
            Self::Lend { version, stamp_us, body } => (2, version, Some(stamp_us), Some(body)),
            Self::Renew { version, stamp_us } => (3, version, Some(stamp_us), None),
            Self::Renewed { version, stamp_us } => (4, version, Some(stamp_us), None),
            Self::Recall { version } => (5, version, None, None),
            Self::Return { version, body } => (6, version, None, Some(body)),
            Self::Taken { version } => (7, version, None, None),
        };
        let mut bytes = [0; Event::MAX_PAYLOAD];
        let mut writer = Writer::new(&mut bytes, "cooperative")
            .put(&[kind, 0])
            .put(&object.to_le_bytes())
            .put(&u32::to_le_bytes(version));
        if let Some(stamp) = stamp {
            writer = writer.put(&stamp.to_le_bytes());
        }
        if let Some(body) = body {
            writer = body.axes.iter().flatten().fold(writer, |writer, number| writer.f64(*number));
        }
        let len = writer.end()?;
        Event::new(code::COOPERATIVE, bytes.get(..len).unwrap_or(&[]))
    }

    /// The object and the message that an event holds.
    pub fn parse(event: &Event) -> Result<(u16, Self), Error> {
        let bytes = event.payload();
        if event.code != code::COOPERATIVE {
            return Err(Error::OutOfRange { message: "cooperative", field: "code" });
        }
        let kind = bytes.first().copied().unwrap_or(0);
        let len = match kind {
            1 | 3 | 4 => HEAD + STAMP,
            2 => HEAD + STAMP + BODY,
            5 | 7 => HEAD,
            6 => HEAD + BODY,
            _ => return Err(Error::UnknownKind { kind }),
        };
        let mut reader = Reader::exact(bytes, "cooperative", len)?;
        reader.u8()?;
        reader.reserved::<1>()?;
        let object = reader.u16()?;
        let version = reader.u32()?;
        let message = match kind {
            1 if version != 0 => return Err(Error::Reserved { message: "cooperative" }),
            1 => Self::Ask { stamp_us: reader.u64()? },
            2 => Self::Lend { version, stamp_us: reader.u64()?, body: body(&mut reader)? },
            3 => Self::Renew { version, stamp_us: reader.u64()? },
            4 => Self::Renewed { version, stamp_us: reader.u64()? },
            5 => Self::Recall { version },
            6 => Self::Return { version, body: body(&mut reader)? },
            _ => Self::Taken { version },
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

#[cfg(test)]
mod tests {
    use super::*;

    const AT: Body = Body { axes: [[1.0, -0.5], [0.25, 0.0]] };

    #[test]
    fn literal_bytes() {
        let renew = Message::Renew { version: 7, stamp_us: 0x0a0b }.event(0x0102).unwrap();
        assert_eq!(renew.code, 0x0201);
        assert_eq!(renew.payload(), [3, 0, 2, 1, 7, 0, 0, 0, 0x0b, 0x0a, 0, 0, 0, 0, 0, 0]);
    }

    #[test]
    fn what_was_said_is_what_is_heard() {
        let all = [
            Message::Ask { stamp_us: u64::MAX },
            Message::Lend { version: 1, stamp_us: 2, body: AT },
            Message::Renew { version: u32::MAX, stamp_us: 0 },
            Message::Renewed { version: 3, stamp_us: 4 },
            Message::Recall { version: 5 },
            Message::Return { version: 6, body: AT },
            Message::Taken { version: 7 },
        ];
        for message in all {
            assert_eq!(Message::parse(&message.event(9).unwrap()), Ok((9, message)));
        }
    }

    #[test]
    fn cut_lengthened_and_broken_bytes_are_refused() {
        let said = Message::Return { version: 6, body: AT }.event(0).unwrap();
        let bytes = said.payload();
        let heard = |bytes: &[u8]| Message::parse(&Event::new(code::COOPERATIVE, bytes).unwrap());
        for len in 0..bytes.len() {
            assert!(heard(&bytes[..len]).is_err());
        }
        assert!(heard(&[bytes, &[0]].concat()).is_err());
        for (at, with) in [(0, 0), (0, 8), (1, 1)] {
            let mut broken = bytes.to_vec();
            broken[at] = with;
            assert!(heard(&broken).is_err());
        }
        let mut broken = bytes.to_vec();
        broken[8..16].copy_from_slice(&f64::NAN.to_le_bytes());
        assert_eq!(heard(&broken), Err(Error::NotFinite { message: "cooperative" }));
        assert!(Message::parse(&Event::new(code::LOCK, bytes).unwrap()).is_err());
    }
}
