//! Presence: where clients are, so that they are aware of each other. A client tells its own place once each packet
//! period, to its server or straight to another client; a server answers with places of others. Newest wins.

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
