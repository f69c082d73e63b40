//! Push: what a client does to the shared object, to whoever moves it; once each packet period, newest wins
//! ([`crate::roles::cooperative`]).
//!
//! | offset | type | field | unit |
//! |---|---|---|---|
//! | 0 | u8 | kind = 19 | |
//! | 1 | u8 × 3 | 0 | |
//! | 4 | u32 | round trip | µs |
//! | 8 | u64 | sent | µs, the client's clock |
//! | 16 | f32 × 2 | force on the object along x and y | N |
//! | 24 | f32 × 2 | where the hand is | m |
//!
//! 32 bytes. A client whose round trip is not known says 2³² − 1.

use super::Error;
use super::bytes::{Reader, Writer};

/// A client's push.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Push {
    /// How long the client takes the way to the engine and back to be, µs: what its contact and the engine's damping follow.
    pub round_trip_us: u32,
    /// When it was sent, µs of the client's clock; what was sent earlier than one that has come is out of date.
    pub sent_us: u64,
    /// Force on the object, N.
    pub force: [f32; 2],
    /// Where the hand is, for others to see, m.
    pub hand: [f32; 2],
}

impl Push {
    /// First byte.
    pub const KIND: u8 = 19;
    /// Bytes.
    pub const LEN: usize = 32;

    /// Reads a push, which must fill `bytes` exactly.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let mut reader = Reader::exact(bytes, "push", Self::LEN)?;
        reader.kind(Self::KIND)?;
        reader.reserved::<3>()?;
        let push = Self {
            round_trip_us: reader.u32()?,
            sent_us: reader.u64()?,
            force: [reader.f32()?, reader.f32()?],
            hand: [reader.f32()?, reader.f32()?],
        };
        reader.end()?;
        Ok(push)
    }

    /// Writes the push to the front of `out` and gives its length.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        let writer = Writer::new(out, "push")
            .put(&[Self::KIND, 0, 0, 0])
            .put(&self.round_trip_us.to_le_bytes())
            .put(&self.sent_us.to_le_bytes());
        self.force.iter().chain(&self.hand).fold(writer, |writer, number| writer.f32(*number)).end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literal_bytes() {
        let push = Push { round_trip_us: 0x0102_0304, sent_us: 5, force: [1.0, -0.5], hand: [2.5, 0.0] };
        let bytes = [
            19, 0, 0, 0, 4, 3, 2, 1, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x80, 0x3f, 0, 0, 0, 0xbf, 0, 0, 0x20, 0x40, 0, 0,
            0, 0,
        ];
        let mut out = [0; Push::LEN];
        assert_eq!(push.emit(&mut out), Ok(Push::LEN));
        assert_eq!(out, bytes);
        assert_eq!(Push::parse(&bytes), Ok(push));
        out[2] = 1;
        assert_eq!(Push::parse(&out), Err(Error::Reserved { message: "push" }));
        out = bytes;
        out[16..20].copy_from_slice(&f32::NAN.to_le_bytes());
        assert_eq!(Push::parse(&out), Err(Error::NotFinite { message: "push" }));
    }
}
