//! Sample: up to 88 bytes of what an instrument saw, once; lost if it is lost. What they mean is the application's.
//!
//! | offset | type | field | unit |
//! |---|---|---|---|
//! | 0 | u8 | kind = 9 | |
//! | 1 | u8 | payload length n, 0 to 88 | bytes |
//! | 2 | u16 | code: what the payload means to the application | |
//! | 4 | u8 × n | payload | |
//!
//! 4 + n bytes.

use super::Error;
use super::bytes::{Reader, Writer};

/// What an instrument saw.
#[derive(Clone, Copy, Debug, Eq)]
pub struct Sample {
    /// What the payload means, for the application to choose.
    pub code: u16,
    payload: [u8; Self::MAX_PAYLOAD],
    len: u8,
}

impl PartialEq for Sample {
    fn eq(&self, other: &Self) -> bool {
        self.code == other.code && self.payload() == other.payload()
    }
}

impl Sample {
    /// First byte.
    pub const KIND: u8 = 9;
    /// Longest payload, bytes.
    pub const MAX_PAYLOAD: usize = 88;
    /// Longest sample, bytes.
    pub const MAX_LEN: usize = Self::HEAD + Self::MAX_PAYLOAD;

    const HEAD: usize = 4;

    /// A sample; its payload may not be longer than [`Sample::MAX_PAYLOAD`].
    pub fn new(code: u16, payload: &[u8]) -> Result<Self, Error> {
        let mut sample = Self { code, payload: [0; Self::MAX_PAYLOAD], len: 0 };
        let too_long = Error::Length { message: "sample payload", wanted: Self::MAX_PAYLOAD, got: payload.len() };
        sample.payload.get_mut(..payload.len()).ok_or(too_long)?.copy_from_slice(payload);
        sample.len = u8::try_from(payload.len()).map_err(|_| too_long)?;
        Ok(sample)
    }

    /// The payload.
    pub fn payload(&self) -> &[u8] {
        self.payload.get(..usize::from(self.len)).unwrap_or(&[])
    }

    /// Reads a sample, which must fill `bytes` exactly.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let len = bytes.get(1).copied().map_or(0, usize::from);
        if len > Self::MAX_PAYLOAD {
            return Err(Error::OutOfRange { message: "sample", field: "payload length" });
        }
        let mut reader = Reader::exact(bytes, "sample", Self::HEAD.saturating_add(len))?;
        reader.kind(Self::KIND)?;
        reader.u8()?;
        let code = reader.u16()?;
        let sample = Self::new(code, reader.slice(len)?)?;
        reader.end()?;
        Ok(sample)
    }

    /// Writes the sample to the front of `out` and gives its length.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        Writer::new(out, "sample").put(&[Self::KIND, self.len]).put(&self.code.to_le_bytes()).put(self.payload()).end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literal_bytes() {
        let sample = Sample::new(0x1234, &[0xaa, 0xbb]).unwrap();
        let bytes = [9, 2, 0x34, 0x12, 0xaa, 0xbb];
        let mut out = [0; Sample::MAX_LEN];
        assert_eq!(sample.emit(&mut out), Ok(6));
        assert_eq!(out[..6], bytes);
        assert_eq!(Sample::parse(&bytes), Ok(sample));
        let longest = Sample::new(1, &[7; 88]).unwrap();
        assert_eq!(longest.emit(&mut out), Ok(92));
        assert_eq!(Sample::parse(&out), Ok(longest));
    }

    #[test]
    fn refuses_lengths_that_are_not_there() {
        assert_eq!(Sample::parse(&[9, 1, 0, 0]), Err(Error::Length { message: "sample", wanted: 5, got: 4 }));
        assert_eq!(Sample::parse(&[9, 0, 0, 0, 0]), Err(Error::Length { message: "sample", wanted: 4, got: 5 }));
        assert_eq!(
            Sample::parse(&[9, 89, 0, 0]),
            Err(Error::OutOfRange { message: "sample", field: "payload length" })
        );
        assert!(Sample::new(0, &[0; 89]).is_err());
    }
}
