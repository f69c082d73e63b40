//! Presence: where clients are, so that they are aware of each other. A client tells its own place once each packet
//! period, to its server or straight to another client; a server answers with places of others. Newest wins.
//!
//! | offset | type | field | unit |
//! |---|---|---|---|
//! | 0 | u8 | kind = 18 | |
//! | 1 | u8 | how many clients n, 0 to 4 | |
//! | 2 | u16 | 0 | |
//! | 4 | u32 | tick: of whoever asked first; a server sends the newest it has from this client | control periods |
//! | 8 + 20·i | u32 | who: the client's line | |
//! | 12 + 20·i | f32 | position x | m |
//! | 16 + 20·i | f32 | position y | m |
//! | 20 + 20·i | f32 | velocity x | m/s |
//! | 24 + 20·i | f32 | velocity y | m/s |
//!
//! 8 + 20·n bytes.

use heapless::Vec;

use super::Error;
use super::bytes::{Reader, Writer};

/// One client seen somewhere.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sighting {
    /// Which client: its line.
    pub who: u32,
    /// Position, m.
    pub position: [f32; 2],
    /// Velocity, m/s.
    pub velocity: [f32; 2],
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
    pub const MAX_LEN: usize = Self::HEAD + Self::EACH * Self::MOST;

    const HEAD: usize = 8;
    const EACH: usize = 20;

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
        if count > Self::MOST {
            return Err(Error::OutOfRange { message: "presence", field: "count" });
        }
        let mut reader = Reader::exact(bytes, "presence", Self::HEAD + Self::EACH * count)?;
        reader.kind(Self::KIND)?;
        reader.u8()?;
        reader.reserved::<2>()?;
        let tick = reader.u32()?;
        let mut seen = Vec::<Sighting, { Self::MOST }>::new();
        for _ in 0..count {
            let sighting = Sighting {
                who: reader.u32()?,
                position: [reader.f32()?, reader.f32()?],
                velocity: [reader.f32()?, reader.f32()?],
            };
            // There is room: `count` was checked.
            let _ = seen.push(sighting);
        }
        reader.end()?;
        Ok(Self::new(tick, seen))
    }

    /// Writes the message to the front of `out` and gives its length.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        let head = Writer::new(out, "presence").put(&[Self::KIND, self.count, 0, 0]).put(&self.tick.to_le_bytes());
        let body = self.seen().iter().fold(head, |out, Sighting { who, position: [x, y], velocity: [u, v] }| {
            out.put(&who.to_le_bytes()).f32(*x).f32(*y).f32(*u).f32(*v)
        });
        body.end()
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
