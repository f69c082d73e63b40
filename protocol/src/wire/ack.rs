//! Acknowledgement: which events have arrived.
//!
//! | offset | type | field | unit |
//! |---|---|---|---|
//! | 0 | u8 | kind = 4 | |
//! | 1 | u8 × 3 | 0 | |
//! | 4 | u32 | next: every event before this number has arrived | |
//! | 8 | u32 | ahead: bit i set = event next + 1 + i has arrived too | |
//!
//! 12 bytes.

use super::Error;
use super::bytes::{Reader, Writer};

/// Which events have arrived.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ack {
    /// Every event before this number has arrived.
    pub next: u32,
    /// Bit i: event `next + 1 + i` has arrived too.
    pub ahead: u32,
}

impl Ack {
    /// First byte.
    pub const KIND: u8 = 4;
    /// Bytes.
    pub const LEN: usize = 12;

    /// Reads an acknowledgement, which must fill `bytes` exactly.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let mut reader = Reader::exact(bytes, "acknowledgement", Self::LEN)?;
        reader.kind(Self::KIND)?;
        reader.reserved::<3>()?;
        let ack = Self { next: reader.u32()?, ahead: reader.u32()? };
        reader.end()?;
        Ok(ack)
    }

    /// Writes the acknowledgement to the front of `out` and gives its length.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        Writer::new(out, "acknowledgement")
            .put(&[Self::KIND, 0, 0, 0])
            .put(&self.next.to_le_bytes())
            .put(&self.ahead.to_le_bytes())
            .end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literal_bytes() {
        let ack = Ack { next: 0x0a0b_0c0d, ahead: 5 };
        let bytes = [4, 0, 0, 0, 0x0d, 0x0c, 0x0b, 0x0a, 5, 0, 0, 0];
        let mut out = [0; Ack::LEN];
        assert_eq!(ack.emit(&mut out), Ok(Ack::LEN));
        assert_eq!(out, bytes);
        assert_eq!(Ack::parse(&bytes), Ok(ack));
    }
}
