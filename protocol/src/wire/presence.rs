//! Presence: where clients are, so that they are aware of each other. A client tells its own place once each packet
//! period, to its server or straight to another client; a server answers with places of others. Newest wins.
//!
//! | offset | type | field | unit |
//! |---|---|---|---|
//! | 0 | u8 | kind = 18 | |
//! | 1 | u8 | how many clients n, 0 to 4 | |
//! | 2 | u16 | 0 | |
//! | 4 | u32 | tick: of whoever asked first; a server sends the newest it has from this client | control periods |
//! | 8 + 20·i | 20 bytes | a [`Sighting`] | |

use crate::bytes::{Reader, Writer, layout};
use crate::error::Error;

layout! {
    /// One client seen somewhere.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct Sighting(20 bytes) {
        /// Which client: its line.
        0 => who: u32,
        /// Position, m.
        4 => position: [f32; 2],
        /// Velocity, m/s.
        12 => velocity: [f32; 2],
    }
}

/// Where clients are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Presence {
    /// The client's tick; in an answer, the newest that the server has from it.
    pub tick: u32,
    seen: [Sighting; Presence::MOST],
    count: u8,
}

impl Presence {
    /// First byte.
    pub const KIND: u8 = 18;
    /// Most clients in one message.
    pub const MOST: usize = 4;
    /// Longest message, bytes.
    pub const MAX_LEN: usize = Self::HEAD + Sighting::LEN * Self::MOST;

    const HEAD: usize = 8;
    /// The first [`Presence::MOST`] of `seen`.
    pub fn new(tick: u32, seen: impl IntoIterator<Item = Sighting>) -> Self {
        let mut presence = Self { tick, ..Self::default() };
        for (to, from) in presence.seen.iter_mut().zip(seen) {
            *to = from;
            presence.count = presence.count.saturating_add(1);
        }
        presence
    }

    /// Who was seen where.
    pub fn seen(&self) -> &[Sighting] {
        self.seen.get(..usize::from(self.count)).unwrap_or(&[])
    }

    /// Reads a message, which must fill `bytes` exactly.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let count = bytes.get(1).copied().map_or(0, usize::from);
        let mut presence = Self::default();
        let seen = presence.seen.get_mut(..count).ok_or(Error::OutOfRange { message: "presence", field: "count" })?;
        let mut reader = Reader::exact(bytes, "presence", Self::HEAD + Sighting::LEN * count)?;
        reader.kind(Self::KIND)?;
        presence.count = reader.get()?;
        reader.zeros_to(4)?;
        presence.tick = reader.get()?;
        for sighting in seen {
            *sighting = reader.get()?;
        }
        Ok(presence)
    }

    /// Writes the message to the front of `out` and gives its length.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        let mut writer = Writer::new(out, "presence");
        writer.bytes(&[Self::KIND, self.count, 0, 0]);
        writer.put(&self.tick);
        self.seen().iter().for_each(|sighting| writer.put(sighting));
        writer.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literal_bytes() {
        let sighting = Sighting { who: 300, position: [1.0, -0.5], velocity: [2.5, 0.0] };
        let presence = Presence::new(0x0102_0304, [sighting]);
        let bytes = [
            18, 1, 0, 0, 4, 3, 2, 1, // head
            0x2c, 1, 0, 0, 0, 0, 0x80, 0x3f, 0, 0, 0, 0xbf, 0, 0, 0x20, 0x40, 0, 0, 0, 0,
        ];
        let mut out = [0; Presence::MAX_LEN];
        assert_eq!(presence.emit(&mut out), Ok(28));
        assert_eq!(out[..28], bytes);
        assert_eq!(Presence::parse(&bytes), Ok(presence));
        assert_eq!(Presence::new(0, [sighting; 9]).seen(), [sighting; 4]);
    }

    #[test]
    fn refuses_more_than_there_is_room_for() {
        let mut bytes = [0; 108];
        bytes[..2].copy_from_slice(&[Presence::KIND, 5]);
        assert_eq!(Presence::parse(&bytes), Err(Error::OutOfRange { message: "presence", field: "count" }));
    }
}
