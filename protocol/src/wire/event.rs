//! Event: something that happens once and must arrive, in order (a hit, a lock, a change of settings).
//!
//! | offset | type | field | unit |
//! |---|---|---|---|
//! | 0 | u8 | kind = 3 | |
//! | 1 | u8 | payload length n, 0 to 48 | bytes |
//! | 2 | u16 | code: what the payload means to the application | |
//! | 4 | u32 | number: 0, 1, 2 … in the order of sending, wraps | |
//! | 8 | u8 × n | payload | |

use super::payload::Payload;
use crate::bytes::Writer;
use crate::error::Error;

/// One event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Event {
    /// Place in the sender's order; [`crate::reliable`] sets it.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literal_bytes() {
        let event = Event::new(0xbeef, &[9, 8, 7]).unwrap().numbered(0x0102_0304);
        let bytes = [3, 3, 0xef, 0xbe, 4, 3, 2, 1, 9, 8, 7];
        let mut out = [0; Event::MAX_LEN];
        assert_eq!(event.emit(&mut out), Ok(bytes.len()));
        assert_eq!(event.emitted_len(), bytes.len());
        assert_eq!(out[..bytes.len()], bytes);
        assert_eq!(Event::parse(&bytes), Ok(event));
    }

    #[test]
    fn payload_up_to_48_bytes() {
        let event = Event::new(1, &[5; 48]).unwrap();
        let mut out = [0; Event::MAX_LEN];
        assert_eq!(event.emit(&mut out), Ok(56));
        assert_eq!(Event::parse(&out), Ok(event));
        let error = Error::Length { message: "event payload", wanted: 48, got: 49 };
        assert_eq!(Event::new(1, &[5; 49]), Err(error));
        let mut long = [0; 57];
        long[0] = Event::KIND;
        long[1] = 49;
        assert_eq!(Event::parse(&long), Err(Error::OutOfRange { message: "event", field: "payload length" }));
    }

    #[test]
    fn empty_and_cut_short() {
        assert_eq!(Event::parse(&[3]), Err(Error::Length { message: "event", wanted: 8, got: 1 }));
        assert_eq!(Event::parse(&[3, 0, 1, 0, 0, 0, 0, 0]), Event::new(1, &[]));
    }
}
