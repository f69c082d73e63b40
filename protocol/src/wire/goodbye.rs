//! Goodbye: the sender ends the session, and says so before it falls silent.
//!
//! | offset | type | field | unit |
//! |---|---|---|---|
//! | 0 | u8 | kind = 7 | |
//! | 1 | u8 × 3 | 0 | |
//!
//! 4 bytes.

use super::Error;
use super::bytes::{Reader, Writer};

/// The sender ends the session.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Goodbye;

impl Goodbye {
    /// First byte.
    pub const KIND: u8 = 7;
    /// Bytes.
    pub const LEN: usize = 4;

    /// Reads a goodbye, which must fill `bytes` exactly.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let mut reader = Reader::exact(bytes, "goodbye", Self::LEN)?;
        reader.kind(Self::KIND)?;
        reader.reserved::<3>()?;
        reader.end()?;
        Ok(Self)
    }

    /// Writes the goodbye to the front of `out` and gives its length.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        Writer::new(out, "goodbye").put(&[Self::KIND, 0, 0, 0]).end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literal_bytes() {
        let mut out = [9; Goodbye::LEN];
        assert_eq!(Goodbye.emit(&mut out), Ok(Goodbye::LEN));
        assert_eq!((out, Goodbye::parse(&out)), ([7, 0, 0, 0], Ok(Goodbye)));
    }
}
