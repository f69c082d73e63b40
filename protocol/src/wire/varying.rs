//! Messages of varying length: events and samples (numbers, and bytes whose meaning is the application's), and where clients are.

use crate::bytes::{Field, Reader, Writer, layout};
use crate::error::Error;

/// Kind, length of the payload, numbers, payload.
macro_rules! with_payload {
    ($(#[$meta:meta])* $Name:ident($message:literal, kind $kind:literal, up to $most:literal bytes) {
        $($field:ident: $ty:ty, $meaning:literal;)+
    }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct $Name {
            $(#[doc = $meaning] pub $field: $ty,)+
            /// Zeros beyond its length, so that equal payloads are equal bytes.
            payload: [u8; $most],
            len: u8,
        }

        impl $Name {
            /// First byte, which names the message.
            pub const KIND: u8 = $kind;
            /// Length of the longest payload, bytes.
            pub const MAX_PAYLOAD: usize = $most;
            /// Longest encoded message, bytes.
            pub const MAX_LEN: usize = Self::HEAD + Self::MAX_PAYLOAD;

            const HEAD: usize = 2 $(+ <$ty as Field>::LEN)+;

            /// A message of this code and payload.
            ///
            /// # Errors
            /// A payload longer than [`Self::MAX_PAYLOAD`].
            pub fn new(code: u16, payload: &[u8]) -> Result<Self, Error> {
                let message = concat!($message, " payload");
                let too_long = Error::length(message, $most, payload.len());
                let len = u8::try_from(payload.len()).map_err(|_| too_long)?;
                let mut new = Self { $($field: <$ty>::default(),)+ payload: [0; $most], len };
                new.payload.get_mut(..payload.len()).ok_or(too_long)?.copy_from_slice(payload);
                new.code = code;
                Ok(new)
            }

            /// The payload as it was sent.
            pub fn payload(&self) -> &[u8] {
                self.payload.get(..usize::from(self.len)).unwrap_or(&[])
            }

            /// Bytes before it is sealed.
            pub fn emitted_len(&self) -> usize {
                Self::HEAD + usize::from(self.len)
            }

            /// Reads the message, which must fill `bytes` exactly.
            ///
            /// # Errors
            /// A wrong length, or a reserved byte that is not 0.
            pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
                let len = bytes.get(1).copied().map_or(0, usize::from);
                if len > Self::MAX_PAYLOAD {
                    return Err(Error::OutOfRange { message: $message, field: "payload length" });
                }
                let mut reader = Reader::exact(bytes, $message, Self::HEAD.saturating_add(len))?;
                reader.kind(Self::KIND)?;
                reader.get::<u8>()?;
                $(let $field = reader.get()?;)+
                let new = Self::new(0, reader.slice(len)?)?;
                Ok(Self { $($field,)+ ..new })
            }

            /// Writes the message to the front of `out` and gives its length, bytes.
            ///
            /// # Errors
            /// Too little room in `out`.
            pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
                let mut writer = Writer::new(out, $message);
                writer.bytes(&[Self::KIND, self.len]);
                $(writer.put(&self.$field);)+
                writer.bytes(self.payload());
                writer.end()
            }
        }
    };
}

with_payload! {
    /// Something that happens once (a hit, a lock, a change of settings), and must arrive, in order.
    Event("event", kind 3, up to 48 bytes) {
        code: u16, "What the payload means, for the application to choose.";
        number: u32, "Place in the sender's order; the link sets it.";
    }
}

with_payload! {
    /// What an instrument saw, once, and lost if it is lost.
    Sample("sample", kind 9, up to 108 bytes) {
        code: u16, "What the payload means, for the application to choose.";
    }
}

impl Event {
    /// This event at another place in the sender's order.
    pub fn numbered(self, number: u32) -> Self {
        Self { number, ..self }
    }
}

layout! {
    /// One client seen somewhere.
    pub struct Sighting(20 bytes) {
        0 => who: u32, "Which client: its line.";
        4 => position: [f32; 2], "Position, m.";
        12 => velocity: [f32; 2], "Velocity, m/s.";
    }
}

/// Where clients are, so that they are aware of each other. A client tells its own place once each packet period, to its server
/// or straight to another client; a server answers with places of others. Newest wins.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Presence {
    /// The client's tick; in an answer, the newest that the server has from it.
    pub tick: u32,
    seen: [Sighting; Presence::MOST],
    count: u8,
}

impl Presence {
    /// First byte, which names the message.
    pub const KIND: u8 = 18;
    /// Most clients in one message.
    pub const MOST: usize = 4;
    /// Longest encoded message, bytes.
    pub const MAX_LEN: usize = Self::HEAD + Sighting::LEN * Self::MOST;

    const HEAD: usize = 8;
    /// The first [`Presence::MOST`] of `seen`.
    pub fn new(tick: u32, seen: impl IntoIterator<Item = Sighting>) -> Self {
        let mut presence = Self { tick, ..Self::default() };
        for (to, from) in presence.seen.iter_mut().zip(seen) {
            *to = from;
            presence.count = presence.count.saturating_add(1);
        }
        presence
    }

    /// Who was seen where.
    pub fn seen(&self) -> &[Sighting] {
        self.seen.get(..usize::from(self.count)).unwrap_or(&[])
    }

    /// Reads a message, which must fill `bytes` exactly.
    ///
    /// # Errors
    /// A wrong length, a reserved byte that is not 0, or a number that is not finite.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let count = bytes.get(1).copied().map_or(0, usize::from);
        let mut presence = Self::default();
        let seen = presence.seen.get_mut(..count).ok_or(Error::OutOfRange { message: "presence", field: "count" })?;
        let mut reader = Reader::exact(bytes, "presence", Self::HEAD + Sighting::LEN * count)?;
        reader.kind(Self::KIND)?;
        presence.count = reader.get()?;
        reader.zeros_to(4)?;
        presence.tick = reader.get()?;
        for sighting in seen {
            *sighting = reader.get()?;
        }
        Ok(presence)
    }

    /// Writes the message to the front of `out` and gives its length.
    ///
    /// # Errors
    /// Too little room in `out`, or a number that is not finite.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        let mut writer = Writer::new(out, "presence");
        writer.bytes(&[Self::KIND, self.count, 0, 0]);
        writer.put(&self.tick);
        self.seen().iter().for_each(|sighting| writer.put(sighting));
        writer.end()
    }
}
