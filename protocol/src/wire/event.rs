//! Event: something that happens once and must arrive, in order (a hit, a lock, a change of settings).

use super::payload::Payload;
use crate::bytes::Writer;
use crate::error::Error;

/// One event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Event {
    /// Place in the sender's order; the link sets it.
    pub number: u32,
    /// What the payload means, for the application to choose.
    pub code: u16,
    payload: Payload<{ Self::MAX_PAYLOAD }>,
}

impl Event {
    /// First byte.
    pub const KIND: u8 = 3;
    /// Longest payload, bytes.
    pub const MAX_PAYLOAD: usize = 48;
    /// Longest event, bytes.
    pub const MAX_LEN: usize = Self::HEAD + Self::MAX_PAYLOAD;

    const HEAD: usize = 8;

    /// An event; its payload may not be longer than [`Event::MAX_PAYLOAD`].
    pub fn new(code: u16, payload: &[u8]) -> Result<Self, Error> {
        Ok(Self { number: 0, code, payload: Payload::new(payload, "event payload")? })
    }

    /// The same event at another place in the sender's order.
    pub fn numbered(self, number: u32) -> Self {
        Self { number, ..self }
    }

    /// The payload.
    pub fn payload(&self) -> &[u8] {
        self.payload.get()
    }

    /// Bytes of the event before it is sealed.
    pub fn emitted_len(&self) -> usize {
        Self::HEAD + usize::from(self.payload.len)
    }

    /// Reads an event, which must fill `bytes` exactly.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let (mut reader, len) = Payload::<{ Self::MAX_PAYLOAD }>::open(bytes, "event", Self::KIND, Self::HEAD)?;
        let (code, number) = (reader.get()?, reader.get()?);
        Ok(Self::new(code, reader.slice(len)?)?.numbered(number))
    }

    /// Writes the event to the front of `out` and gives its length.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        let mut writer = Writer::new(out, "event");
        writer.bytes(&[Self::KIND, self.payload.len]);
        writer.put(&self.code);
        writer.put(&self.number);
        writer.bytes(self.payload());
        writer.end()
    }
}
