//! Header: what can be read of a sealed datagram. It is authenticated together with what it heads.
//!
//! | offset | type | field | unit |
//! |---|---|---|---|
//! | 0 | u8 | version = 1 | |
//! | 1 | u8 | kind = 3 (sealed); 1 and 2 are greetings | |
//! | 2 | u8 | from: the sender's number | |
//! | 3 | u8 | to: the receiver's number | |
//! | 4 | u32 | session: which keys opened it, 0 in greetings | |
//! | 8 | u64 | sequence: grows by 1 with every sealed datagram of the sender; also the nonce | |
//!
//! 16 bytes, then the sealed message, then a tag of 16 bytes.

use super::bytes::{Reader, Writer};
use super::{Error, TAG_LEN, VERSION};

/// Which peer of the installation; the two ends of a link have different numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct PeerId(pub u8);

/// The readable part of a sealed datagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// Who sent it.
    pub from: PeerId,
    /// For whom it is.
    pub to: PeerId,
    /// Which session's keys seal it.
    pub session: u32,
    /// Place in the sender's order, and the nonce.
    pub sequence: u64,
}

impl Header {
    /// Second byte of a sealed datagram.
    pub const KIND: u8 = 3;
    /// Bytes.
    pub const LEN: usize = 16;

    /// Takes a sealed datagram apart: header as bytes and as fields, and the sealed rest with its tag.
    pub fn parse(datagram: &mut [u8]) -> Result<(Self, &[u8; Self::LEN], &mut [u8]), Error> {
        let least = Error::Length { message: "sealed", wanted: Self::LEN + TAG_LEN, got: datagram.len() };
        if datagram.len() < Self::LEN + TAG_LEN {
            return Err(least);
        }
        let (head, sealed) = datagram.split_first_chunk_mut::<{ Self::LEN }>().ok_or(least)?;
        let mut reader = Reader::exact(head, "header", Self::LEN)?;
        let version = reader.u8()?;
        if version != VERSION {
            return Err(Error::UnknownVersion { version });
        }
        reader.kind(Self::KIND)?;
        let header = Self {
            from: PeerId(reader.u8()?),
            to: PeerId(reader.u8()?),
            session: reader.u32()?,
            sequence: reader.u64()?,
        };
        reader.end()?;
        Ok((header, head, sealed))
    }

    /// The header as bytes.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        Writer::new(out, "header")
            .put(&[VERSION, Self::KIND, self.from.0, self.to.0])
            .put(&self.session.to_le_bytes())
            .put(&self.sequence.to_le_bytes())
            .end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BYTES: [u8; 16] = [1, 3, 7, 9, 0xdd, 0xcc, 0xbb, 0xaa, 8, 7, 6, 5, 4, 3, 2, 1];

    #[test]
    fn literal_bytes() {
        let header = Header { from: PeerId(7), to: PeerId(9), session: 0xaabb_ccdd, sequence: 0x0102_0304_0506_0708 };
        let mut out = [0; Header::LEN];
        assert_eq!(header.emit(&mut out), Ok(Header::LEN));
        assert_eq!(out, BYTES);
        let mut datagram = [0x55; 33];
        datagram[..16].copy_from_slice(&BYTES);
        assert_eq!(Header::parse(&mut datagram), Ok((header, &BYTES, &mut [0x55; 17][..])));
    }

    #[test]
    fn refuses_other_versions_kinds_and_lengths() {
        let mut datagram = [0; 32];
        datagram[..16].copy_from_slice(&BYTES);
        datagram[0] = 2;
        assert_eq!(Header::parse(&mut datagram), Err(Error::UnknownVersion { version: 2 }));
        datagram[..2].copy_from_slice(&[1, 4]);
        assert_eq!(Header::parse(&mut datagram), Err(Error::UnknownKind { kind: 4 }));
        let error = Error::Length { message: "sealed", wanted: 32, got: 31 };
        assert_eq!(Header::parse(&mut datagram[..31]), Err(error));
    }
}
