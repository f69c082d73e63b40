//! Event: something that happens once and must arrive, in order (a hit, a lock, a change of settings).
//!
//! | offset | type | field | unit |
//! |---|---|---|---|
//! | 0 | u8 | kind = 3 | |
//! | 1 | u8 | payload length n, 0 to 48 | bytes |
//! | 2 | u16 | code: what the payload means to the application | |
//! | 4 | u32 | number: 0, 1, 2 … in the order of sending, wraps | |
//! | 8 | u8 × n | payload | |
//!
//! 8 + n bytes.

use super::Error;
use super::bytes::{Reader, Writer};

/// One event.
#[derive(Clone, Copy, Debug, Eq)]
pub struct Event {
    /// Place in the sender's order; [`crate::reliable`] sets it.
    pub number: u32,
    /// What the payload means, for the application to choose.
    pub code: u16,
    payload: [u8; Self::MAX_PAYLOAD],
    len: u8,
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
        let mut event = Self { number: 0, code, payload: [0; Self::MAX_PAYLOAD], len: 0 };
        let too_long = Error::Length { message: "event payload", wanted: Self::MAX_PAYLOAD, got: payload.len() };
        event.payload.get_mut(..payload.len()).ok_or(too_long)?.copy_from_slice(payload);
        event.len = u8::try_from(payload.len()).map_err(|_| too_long)?;
        Ok(event)
    }

    /// The same event at another place in the sender's order.
    pub fn numbered(self, number: u32) -> Self {
        Self { number, ..self }
    }

    /// The payload.
    pub fn payload(&self) -> &[u8] {
        self.payload.get(..usize::from(self.len)).unwrap_or(&[])
    }

    /// Bytes of the event before it is sealed.
    pub fn emitted_len(&self) -> usize {
        Self::HEAD + usize::from(self.len)
    }

    /// Reads an event, which must fill `bytes` exactly.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let len = bytes.get(1).copied().map_or(0, usize::from);
        if len > Self::MAX_PAYLOAD {
            return Err(Error::OutOfRange { message: "event", field: "payload length" });
        }
        let mut reader = Reader::exact(bytes, "event", Self::HEAD.saturating_add(len))?;
        reader.kind(Self::KIND)?;
        reader.u8()?;
        let code = reader.u16()?;
        let number = reader.u32()?;
        let event = Self::new(code, reader.slice(len)?)?;
        reader.end()?;
        Ok(event.numbered(number))
    }

    /// Writes the event to the front of `out` and gives its length.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        Writer::new(out, "event")
            .put(&[Self::KIND, self.len])
            .put(&self.code.to_le_bytes())
            .put(&self.number.to_le_bytes())
            .put(self.payload())
            .end()
    }
}

impl PartialEq for Event {
    fn eq(&self, other: &Self) -> bool {
        self.number == other.number && self.code == other.code && self.payload() == other.payload()
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
