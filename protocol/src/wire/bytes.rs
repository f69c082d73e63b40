//! Reading and writing fields in order, without an index that could be wrong.
//!
//! A [`Reader`] is opened on exactly as many bytes as the layout has; a [`Writer`] on room for at least as many. Every
//! step checks again, so that a layout that disagrees with its length is an error and never a panic.

use super::Error;

/// Takes fields off the front of a message.
pub(crate) struct Reader<'a> {
    rest: &'a [u8],
    message: &'static str,
    wanted: usize,
    got: usize,
}

impl<'a> Reader<'a> {
    /// Opens `bytes` as a `message` that is `wanted` bytes long.
    pub(crate) fn exact(bytes: &'a [u8], message: &'static str, wanted: usize) -> Result<Self, Error> {
        let reader = Self { rest: bytes, message, wanted, got: bytes.len() };
        if bytes.len() == wanted { Ok(reader) } else { Err(reader.length()) }
    }

    fn length(&self) -> Error {
        Error::Length { message: self.message, wanted: self.wanted, got: self.got }
    }

    /// The next `N` bytes as they are.
    pub(crate) fn array<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        let (field, rest) = self.rest.split_first_chunk().ok_or(self.length())?;
        self.rest = rest;
        Ok(*field)
    }

    /// The next `count` bytes as they are.
    pub(crate) fn slice(&mut self, count: usize) -> Result<&'a [u8], Error> {
        let (field, rest) = self.rest.split_at_checked(count).ok_or(self.length())?;
        self.rest = rest;
        Ok(field)
    }

    pub(crate) fn u8(&mut self) -> Result<u8, Error> {
        self.array().map(u8::from_le_bytes)
    }

    pub(crate) fn u16(&mut self) -> Result<u16, Error> {
        self.array().map(u16::from_le_bytes)
    }

    pub(crate) fn u32(&mut self) -> Result<u32, Error> {
        self.array().map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self) -> Result<u64, Error> {
        self.array().map(u64::from_le_bytes)
    }

    pub(crate) fn i64(&mut self) -> Result<i64, Error> {
        self.array().map(i64::from_le_bytes)
    }

    /// A finite number.
    pub(crate) fn f32(&mut self) -> Result<f32, Error> {
        let number = f32::from_le_bytes(self.array()?);
        if number.is_finite() { Ok(number) } else { Err(Error::NotFinite { message: self.message }) }
    }

    /// A finite number.
    pub(crate) fn f64(&mut self) -> Result<f64, Error> {
        let number = f64::from_le_bytes(self.array()?);
        if number.is_finite() { Ok(number) } else { Err(Error::NotFinite { message: self.message }) }
    }

    /// `N` bytes that must be 0.
    pub(crate) fn reserved<const N: usize>(&mut self) -> Result<(), Error> {
        if self.array::<N>()? == [0; N] { Ok(()) } else { Err(Error::Reserved { message: self.message }) }
    }

    /// The kind byte, which the caller has looked at already.
    pub(crate) fn kind(&mut self, wanted: u8) -> Result<(), Error> {
        let kind = self.u8()?;
        if kind == wanted { Ok(()) } else { Err(Error::UnknownKind { kind }) }
    }

    /// Every byte has been taken.
    pub(crate) fn end(self) -> Result<(), Error> {
        if self.rest.is_empty() { Ok(()) } else { Err(self.length()) }
    }
}

/// Puts fields one after the other into a buffer.
pub(crate) struct Writer<'a> {
    rest: &'a mut [u8],
    written: usize,
    room: usize,
    finite: bool,
    message: &'static str,
}

impl<'a> Writer<'a> {
    /// Starts a `message` at the front of `out`.
    pub(crate) fn new(out: &'a mut [u8], message: &'static str) -> Self {
        let room = out.len();
        Self { rest: out, written: 0, room, finite: true, message }
    }

    /// The next bytes; once something did not fit, [`Writer::end`] says so.
    pub(crate) fn put(mut self, field: &[u8]) -> Self {
        self.written = self.written.saturating_add(field.len());
        let rest = core::mem::take(&mut self.rest);
        if let Some((to, rest)) = rest.split_at_mut_checked(field.len()) {
            to.copy_from_slice(field);
            self.rest = rest;
        }
        self
    }

    /// A number, which must be finite.
    pub(crate) fn f32(mut self, number: f32) -> Self {
        self.finite &= number.is_finite();
        self.put(&number.to_le_bytes())
    }

    /// A number, which must be finite.
    pub(crate) fn f64(mut self, number: f64) -> Self {
        self.finite &= number.is_finite();
        self.put(&number.to_le_bytes())
    }

    /// The length written, or what was wrong.
    pub(crate) fn end(self) -> Result<usize, Error> {
        if !self.finite {
            Err(Error::NotFinite { message: self.message })
        } else if self.written <= self.room {
            Ok(self.written)
        } else {
            Err(Error::Length { message: self.message, wanted: self.written, got: self.room })
        }
    }
}
