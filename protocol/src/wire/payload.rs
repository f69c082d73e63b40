//! Event and sample: numbers, and bytes whose meaning is the application's. An event must arrive, in order (a hit, a lock, a change
//! of settings); a sample is what an instrument saw, once, and lost if it is lost.

use core::fmt;

use crate::bytes::{Field, Reader, Writer};
use crate::error::Error;

/// Up to `N` bytes.
#[derive(Clone, Copy)]
struct Bytes<const N: usize> {
    bytes: [u8; N],
    len: u8,
}

impl<const N: usize> Bytes<N> {
    fn get(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.len)).unwrap_or(&[])
    }
}

impl<const N: usize> PartialEq for Bytes<N> {
    fn eq(&self, other: &Self) -> bool {
        self.get() == other.get()
    }
}

impl<const N: usize> Eq for Bytes<N> {}

impl<const N: usize> fmt::Debug for Bytes<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.get().fmt(f)
    }
}

/// Kind, length of the payload, numbers, payload.
macro_rules! with_payload {
    ($(#[$meta:meta])* $Name:ident($message:literal, kind $kind:literal, up to $most:literal bytes) {
        $($(#[$field_meta:meta])* $field:ident: $ty:ty,)+
    }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct $Name {
            $($(#[$field_meta])* pub $field: $ty,)+
            payload: Bytes<$most>,
        }

        impl $Name {
            /// First byte.
            pub const KIND: u8 = $kind;
            /// Longest payload, bytes.
            pub const MAX_PAYLOAD: usize = $most;
            /// Longest one, bytes.
            pub const MAX_LEN: usize = Self::HEAD + Self::MAX_PAYLOAD;

            const HEAD: usize = 2 $(+ <$ty as Field>::LEN)+;

            /// A new one; its payload may not be longer than [`Self::MAX_PAYLOAD`].
            pub fn new(code: u16, payload: &[u8]) -> Result<Self, Error> {
                let message = concat!($message, " payload");
                let too_long = Error::Length { message, wanted: $most, got: payload.len() };
                let len = u8::try_from(payload.len()).map_err(|_| too_long)?;
                let mut bytes = [0; $most];
                bytes.get_mut(..payload.len()).ok_or(too_long)?.copy_from_slice(payload);
                let empty = Self { $($field: <$ty>::default(),)+ payload: Bytes { bytes, len } };
                Ok(Self { code, ..empty })
            }

            /// The payload.
            pub fn payload(&self) -> &[u8] {
                self.payload.get()
            }

            /// Bytes before it is sealed.
            pub fn emitted_len(&self) -> usize {
                Self::HEAD + usize::from(self.payload.len)
            }

            /// Reads one, which must fill `bytes` exactly.
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

            /// Writes it to the front of `out` and gives its length.
            pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
                let mut writer = Writer::new(out, $message);
                writer.bytes(&[Self::KIND, self.payload.len]);
                $(writer.put(&self.$field);)+
                writer.bytes(self.payload());
                writer.end()
            }
        }
    };
}

with_payload! {
    /// Something that happens once.
    Event("event", kind 3, up to 48 bytes) {
        /// What the payload means, for the application to choose.
        code: u16,
        /// Place in the sender's order; the link sets it.
        number: u32,
    }
}

with_payload! {
    /// What an instrument saw.
    Sample("sample", kind 9, up to 88 bytes) {
        /// What the payload means, for the application to choose.
        code: u16,
    }
}

impl Event {
    /// The same event at another place in the sender's order.
    pub fn numbered(self, number: u32) -> Self {
        Self { number, ..self }
    }
}
