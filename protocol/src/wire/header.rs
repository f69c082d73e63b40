//! Header: what can be read of a sealed datagram. It is authenticated together with what it heads: 16 bytes, then the sealed
//! message, then a tag of 16 bytes. Kinds 1 and 2 are greetings.

use crate::bytes::{Reader, emit, layout, newtype};
use crate::error::{Error, VERSION};
use crate::key::TAG_LEN;

/// Which peer of the installation; the two ends of a link have different numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct PeerId(pub u8);

newtype!(PeerId);

layout! {
    /// The readable part of a sealed datagram.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct Header(16 bytes, version VERSION, kind 3) {
        /// Who sent it.
        2 => from: PeerId,
        /// For whom it is.
        3 => to: PeerId,
        /// Which session's keys seal it.
        4 => session: u32,
        /// Place in the sender's order, and the nonce.
        8 => sequence: u64,
    }
}

impl Header {
    /// Takes a sealed datagram apart: header as bytes and as fields, and the sealed rest with its tag.
    pub fn parse(datagram: &mut [u8]) -> Result<(Self, &[u8; Self::LEN], &mut [u8]), Error> {
        let least = Error::Length { message: "sealed", wanted: Self::LEN + TAG_LEN, got: datagram.len() };
        if datagram.len() < Self::LEN + TAG_LEN {
            return Err(least);
        }
        let (head, sealed) = datagram.split_first_chunk_mut::<{ Self::LEN }>().ok_or(least)?;
        let header = Reader::exact(head, "header", Self::LEN)?.get()?;
        Ok((header, head, sealed))
    }

    /// The header as bytes.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        emit(self, "header", out)
    }
}
