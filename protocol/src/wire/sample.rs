//! Sample: up to 88 bytes of what an instrument saw, once; lost if it is lost. What they mean is the application's.
//!
//! | offset | type | field | unit |
//! |---|---|---|---|
//! | 0 | u8 | kind = 9 | |
//! | 1 | u8 | payload length n, 0 to 88 | bytes |
//! | 2 | u16 | code: what the payload means to the application | |
//! | 4 | u8 × n | payload | |

use super::payload::Payload;
use crate::bytes::Writer;
use crate::error::Error;

/// What an instrument saw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// What the payload means, for the application to choose.
    pub code: u16,
    payload: Payload<{ Self::MAX_PAYLOAD }>,
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
        Ok(Self { code, payload: Payload::new(payload, "sample payload")? })
    }

    /// The payload.
    pub fn payload(&self) -> &[u8] {
        self.payload.get()
    }

    /// Reads a sample, which must fill `bytes` exactly.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let (mut reader, len) = Payload::<{ Self::MAX_PAYLOAD }>::open(bytes, "sample", Self::KIND, Self::HEAD)?;
        let code = reader.get()?;
        Self::new(code, reader.slice(len)?)
    }

    /// Writes the sample to the front of `out` and gives its length.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        let mut writer = Writer::new(out, "sample");
        writer.bytes(&[Self::KIND, self.payload.len]);
        writer.put(&self.code);
        writer.bytes(self.payload());
        writer.end()
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
