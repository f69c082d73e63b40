//! Payload: up to `N` bytes whose meaning is the application's.

use core::fmt;

use crate::bytes::Reader;
use crate::error::Error;

/// Up to `N` bytes.
#[derive(Clone, Copy)]
pub(super) struct Payload<const N: usize> {
    bytes: [u8; N],
    pub(super) len: u8,
}

impl<const N: usize> Payload<N> {
    /// A copy of these; `message` names them where they are too many.
    pub(super) fn new(payload: &[u8], message: &'static str) -> Result<Self, Error> {
        let mut bytes = [0; N];
        let too_long = Error::Length { message, wanted: N, got: payload.len() };
        bytes.get_mut(..payload.len()).ok_or(too_long)?.copy_from_slice(payload);
        Ok(Self { bytes, len: u8::try_from(payload.len()).map_err(|_| too_long)? })
    }

    /// The bytes.
    pub(super) fn get(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.len)).unwrap_or(&[])
    }

    /// Opens a message of `head` bytes, the second of which is the length of the payload that follows; gives that length, too.
    pub(super) fn open<'a>(
        bytes: &'a [u8],
        message: &'static str,
        kind: u8,
        head: usize,
    ) -> Result<(Reader<'a>, usize), Error> {
        let len = bytes.get(1).copied().map_or(0, usize::from);
        if len > N {
            return Err(Error::OutOfRange { message, field: "payload length" });
        }
        let mut reader = Reader::exact(bytes, message, head.saturating_add(len))?;
        reader.kind(kind)?;
        reader.get::<u8>()?;
        Ok((reader, len))
    }
}

impl<const N: usize> PartialEq for Payload<N> {
    fn eq(&self, other: &Self) -> bool {
        self.get() == other.get()
    }
}

impl<const N: usize> Eq for Payload<N> {}

impl<const N: usize> fmt::Debug for Payload<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.get().fmt(f)
    }
}
