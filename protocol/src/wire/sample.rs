//! Sample: up to 88 bytes of what an instrument saw, once; lost if it is lost. What they mean is the application's.

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
