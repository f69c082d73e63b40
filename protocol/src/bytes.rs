//! Fields of fixed layout, and the macros that declare what is made of them: [`layout!`] a struct, [`byte_enum!`] names of bytes.
//! A message of one's own, in [`crate::wire::Event`]s or samples, is declared with the same.
//!
//! Everything is little-endian. A [`Reader`] is opened on exactly as many bytes as the layout has; a [`Writer`] on room for at
//! least as many. Every step checks again, so that a layout that disagrees with its length is an error and never a panic.

use crate::error::Error;

/// Takes fields off the front of a message.
pub struct Reader<'a> {
    rest: &'a [u8],
    message: &'static str,
    wanted: usize,
    got: usize,
}

impl<'a> Reader<'a> {
    /// Opens a reader on exactly `wanted` bytes of a `message`.
    ///
    /// # Errors
    /// Another length.
    pub fn exact(bytes: &'a [u8], message: &'static str, wanted: usize) -> Result<Self, Error> {
        let reader = Self { rest: bytes, message, wanted, got: bytes.len() };
        if bytes.len() == wanted { Ok(reader) } else { Err(reader.length()) }
    }

    /// The error of a wrong length.
    pub fn length(&self) -> Error {
        Error::length(self.message, self.wanted, self.got)
    }

    /// Offset of the next byte.
    #[inline]
    pub fn at(&self) -> usize {
        self.got.saturating_sub(self.rest.len())
    }

    /// The next field.
    ///
    /// # Errors
    /// Too few bytes, or a value without a meaning.
    #[inline]
    pub fn get<T: Field>(&mut self) -> Result<T, Error> {
        T::read(self)
    }

    /// The next `N` bytes.
    ///
    /// # Errors
    /// Too few bytes.
    #[inline]
    pub fn array<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        let (field, rest) = self.rest.split_first_chunk().ok_or(self.length())?;
        self.rest = rest;
        Ok(*field)
    }

    /// The next `count` bytes.
    ///
    /// # Errors
    /// Too few bytes.
    #[inline]
    pub fn slice(&mut self, count: usize) -> Result<&'a [u8], Error> {
        let (field, rest) = self.rest.split_at_checked(count).ok_or(self.length())?;
        self.rest = rest;
        Ok(field)
    }

    /// What lies before offset `at` must be 0.
    #[inline]
    pub fn zeros_to(&mut self, at: usize) -> Result<(), Error> {
        self.zeros(at.saturating_sub(self.at()))
    }

    /// So many bytes must be 0.
    #[inline]
    pub fn zeros(&mut self, count: usize) -> Result<(), Error> {
        let gap = self.slice(count)?;
        if gap.iter().all(|byte| *byte == 0) { Ok(()) } else { Err(self.reserved()) }
    }

    /// The version byte, which must be `wanted`.
    ///
    /// # Errors
    /// Another version.
    pub fn version(&mut self, wanted: u8) -> Result<(), Error> {
        let version = self.get()?;
        if version == wanted { Ok(()) } else { Err(Error::UnknownVersion(version)) }
    }

    /// The kind byte, which the caller has looked at already.
    pub fn kind(&mut self, wanted: u8) -> Result<(), Error> {
        let kind = self.get()?;
        if kind == wanted { Ok(()) } else { Err(Error::UnknownKind(kind)) }
    }

    /// The error of a reserved byte that is not 0.
    pub fn reserved(&self) -> Error {
        Error::Reserved(self.message)
    }

    /// The error of a `field` whose value has no meaning.
    pub fn out_of_range(&self, field: &'static str) -> Error {
        Error::OutOfRange { message: self.message, field }
    }
}

/// Puts fields one after the other into a buffer; once something did not fit, [`Writer::end`] says so.
pub struct Writer<'a> {
    rest: &'a mut [u8],
    written: usize,
    room: usize,
    finite: bool,
    message: &'static str,
}

impl<'a> Writer<'a> {
    /// Opens a writer of a `message` on the front of `out`.
    pub fn new(out: &'a mut [u8], message: &'static str) -> Self {
        let room = out.len();
        Self { rest: out, written: 0, room, finite: true, message }
    }

    /// Offset of the next byte.
    #[inline]
    pub fn at(&self) -> usize {
        self.written
    }

    /// Appends a field.
    #[inline]
    pub fn put(&mut self, field: &impl Field) {
        field.write(self);
    }

    /// Appends bytes as they are.
    #[inline]
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.written = self.written.saturating_add(bytes.len());
        let rest = core::mem::take(&mut self.rest);
        if let Some((to, rest)) = rest.split_at_mut_checked(bytes.len()) {
            to.copy_from_slice(bytes);
            self.rest = rest;
        }
    }

    /// Appends zeros up to offset `at`.
    #[inline]
    pub fn zeros_to(&mut self, at: usize) {
        while let Some(gap) = at.checked_sub(self.written).filter(|gap| *gap > 0) {
            self.bytes([0; 8].get(..gap).unwrap_or(&[0; 8]));
        }
    }

    /// How many bytes were written.
    ///
    /// # Errors
    /// Too little room, or a number that is not finite.
    pub fn end(self) -> Result<usize, Error> {
        if !self.finite {
            Err(Error::NotFinite(self.message))
        } else if self.written <= self.room {
            Ok(self.written)
        } else {
            Err(Error::length(self.message, self.written, self.room))
        }
    }
}

/// Writes a `message` that is one field to the front of `out` and gives its length.
pub fn emit(field: &impl Field, message: &'static str, out: &mut [u8]) -> Result<usize, Error> {
    let mut writer = Writer::new(out, message);
    writer.put(field);
    writer.end()
}

/// A value of fixed length in a message.
pub trait Field: Sized {
    /// Length of the encoded value, bytes.
    const LEN: usize;
    /// Takes the value off the front of a message.
    ///
    /// # Errors
    /// Too few bytes, or a value without a meaning.
    fn read(reader: &mut Reader<'_>) -> Result<Self, Error>;
    /// Appends the value to a message.
    fn write(&self, writer: &mut Writer<'_>);

    /// Takes as many values as there is room for in `all`.
    ///
    /// # Errors
    /// As [`Field::read`].
    #[inline]
    fn read_all(reader: &mut Reader<'_>, all: &mut [Self]) -> Result<(), Error> {
        for one in all {
            *one = reader.get()?;
        }
        Ok(())
    }

    /// Appends all values in order.
    fn write_all(all: &[Self], writer: &mut Writer<'_>) {
        all.iter().for_each(|one| one.write(writer));
    }
}

/// Bytes are copied at once where there are several.
impl Field for u8 {
    const LEN: usize = 1;

    #[inline]
    fn read(reader: &mut Reader<'_>) -> Result<Self, Error> {
        reader.array().map(|[byte]| byte)
    }

    #[inline]
    fn write(&self, writer: &mut Writer<'_>) {
        writer.bytes(&[*self]);
    }

    fn read_all(reader: &mut Reader<'_>, all: &mut [Self]) -> Result<(), Error> {
        let bytes = reader.slice(all.len())?;
        all.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from);
        Ok(())
    }

    fn write_all(all: &[Self], writer: &mut Writer<'_>) {
        writer.bytes(all);
    }
}

macro_rules! numbers {
    ($($Number:ty, $fits:expr;)+) => {$(
        impl Field for $Number {
            const LEN: usize = size_of::<Self>();

            #[inline]
            fn read(reader: &mut Reader<'_>) -> Result<Self, Error> {
                let fits: fn(Self) -> bool = $fits;
                let number = Self::from_le_bytes(reader.array()?);
                if fits(number) { Ok(number) } else { Err(Error::NotFinite(reader.message)) }
            }

            #[inline]
            fn write(&self, writer: &mut Writer<'_>) {
                let fits: fn(Self) -> bool = $fits;
                writer.finite &= fits(*self);
                writer.bytes(&self.to_le_bytes());
            }
        }
    )+};
}

numbers! {
    u16, |_| true;
    u32, |_| true;
    u64, |_| true;
    i64, |_| true;
    f32, Self::is_finite;
    f64, Self::is_finite;
}

impl<T: Field + Copy + Default, const N: usize> Field for [T; N] {
    const LEN: usize = N * T::LEN;

    #[inline]
    fn read(reader: &mut Reader<'_>) -> Result<Self, Error> {
        let mut all = [T::default(); N];
        T::read_all(reader, &mut all)?;
        Ok(all)
    }

    #[inline]
    fn write(&self, writer: &mut Writer<'_>) {
        T::write_all(self, writer);
    }
}

/// A bit of a message's second byte, and what follows at its end where the bit is set.
pub trait Flag: Sized {
    /// Bytes that follow where it is set.
    const TAIL: usize;
    /// Whether the bit is set.
    fn is_set(&self) -> bool;
    /// Takes what follows, where the bit is `set`.
    ///
    /// # Errors
    /// Too few bytes, or a value without a meaning.
    fn read(set: bool, reader: &mut Reader<'_>) -> Result<Self, Error>;
    /// Appends what follows, where the bit is set.
    fn write(&self, writer: &mut Writer<'_>);
}

impl Flag for bool {
    const TAIL: usize = 0;

    fn is_set(&self) -> bool {
        *self
    }

    fn read(set: bool, _: &mut Reader<'_>) -> Result<Self, Error> {
        Ok(set)
    }

    fn write(&self, _: &mut Writer<'_>) {}
}

impl<T: Field> Flag for Option<T> {
    const TAIL: usize = T::LEN;

    fn is_set(&self) -> bool {
        self.is_some()
    }

    fn read(set: bool, reader: &mut Reader<'_>) -> Result<Self, Error> {
        set.then(|| reader.get()).transpose()
    }

    #[inline]
    fn write(&self, writer: &mut Writer<'_>) {
        self.iter().for_each(|value| writer.put(value));
    }
}

/// Flags as a byte, the first in the lowest bit.
pub fn byte_of(flags: &[bool]) -> u8 {
    flags.iter().rev().fold(0, |byte, flag| byte << 1 | u8::from(*flag))
}

/// A struct of fixed layout: each field with its offset, its meaning and, where not every value has one, which ones do. What no
/// field takes is 0. A `message` is one by itself, and has `parse` and `emit`; a `struct` is a field of others.
///
/// ```text
/// layout! {
///     pub message Flow("flow", 40 bytes, kind 1) {
///         flags at 1 { engaged, "What it says."; }
///         4 => tick: u32, "What it says.";
///         8 => position: f32 where |position| *position > 0.0, "What it says.";
///     }
/// }
/// ```
#[macro_export]
macro_rules! layout {
    (
        $(#[$meta:meta])*
        pub message $Name:ident($message:literal, $len:literal bytes $(, $first:ident $value:expr)+) { $($body:tt)* }
    ) => {
        $crate::layout! { $(#[$meta])* pub struct $Name($len bytes $(, $first $value)+) { $($body)* } }

        impl $Name {
            /// Reads the message, which must fill `bytes` exactly.
            ///
            /// # Errors
            /// A wrong length, a reserved byte that is not 0, or a field without a meaning.
            pub fn parse(bytes: &[u8]) -> Result<Self, $crate::wire::Error> {
                $crate::bytes::Reader::exact(bytes, $message, Self::LEN)?.get()
            }

            /// Writes the message to the front of `out` and gives its length, bytes.
            ///
            /// # Errors
            /// Too little room in `out`, or a number that is not finite.
            pub fn emit(&self, out: &mut [u8]) -> Result<usize, $crate::wire::Error> {
                $crate::bytes::emit(self, $message, out)
            }
        }
    };
    (
        $(#[$meta:meta])*
        pub struct $Name:ident($len:literal bytes $(, $first:ident $value:expr)*) {
            $(flags at $at:literal { $($flag:ident, $flag_doc:literal;)+ })?
            $($offset:literal => $field:ident: $ty:ty $(where $allowed:expr)?, $doc:literal;)*
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct $Name {
            $($(#[doc = $flag_doc] pub $flag: bool,)+)?
            $(#[doc = $doc] pub $field: $ty,)*
        }

        impl $Name {
            $($crate::layout! { @first $first $value })*
            /// Length of the encoded value, bytes.
            pub const LEN: usize = $len;
        }

        impl $crate::bytes::Field for $Name {
            const LEN: usize = {
                let mut _end = 0;
                $(_end = { assert!(_end <= $offset, "fields overlap"); $offset + <$ty as $crate::bytes::Field>::LEN };)*
                assert!(_end <= $len, "a field is beyond the end");
                $len
            };

            #[inline]
            fn read(reader: &mut $crate::bytes::Reader<'_>) -> Result<Self, $crate::wire::Error> {
                // Known when this is compiled, wherever the struct begins: where no gap is, none is looked for.
                let mut _at: usize = 0;
                $(reader.$first($value)?; _at = usize::saturating_add(_at, 1);)*
                $(
                    reader.zeros(usize::saturating_sub($at, _at))?;
                    let mut flags: u8 = reader.get()?;
                    _at = $at + 1;
                    $(let $flag = flags & 1 == 1; flags >>= 1;)+
                    if flags != 0 {
                        return Err(reader.reserved());
                    }
                )?
                $(
                    reader.zeros(usize::saturating_sub($offset, _at))?;
                    let $field: $ty = reader.get()?;
                    _at = $offset + <$ty as $crate::bytes::Field>::LEN;
                    $(
                        let allowed: fn(&$ty) -> bool = $allowed;
                        if !allowed(&$field) {
                            return Err(reader.out_of_range(stringify!($field)));
                        }
                    )?
                )*
                reader.zeros(usize::saturating_sub($len, _at))?;
                Ok(Self { $($($flag,)+)? $($field,)* })
            }

            #[inline]
            fn write(&self, writer: &mut $crate::bytes::Writer<'_>) {
                let start = writer.at();
                $(writer.bytes(&[$value]);)*
                $(
                    writer.zeros_to(start + $at);
                    writer.put(&$crate::bytes::byte_of(&[$(self.$flag),+]));
                )?
                $(
                    writer.zeros_to(start + $offset);
                    writer.put(&self.$field);
                )*
                writer.zeros_to(start + $len);
            }
        }
    };
    (@first kind $value:expr) => {
        /// Byte that names it.
        pub const KIND: u8 = $value;
    };
    (@first version $value:expr) => {};
}

/// A name for each of some bytes, the first one by default; the others have no meaning.
#[macro_export]
macro_rules! byte_enum {
    (
        $(#[$meta:meta])*
        pub enum $Name:ident($field:literal) {
            $first_value:literal => $First:ident, $first_doc:literal;
            $($value:literal => $Variant:ident, $doc:literal;)+
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        #[repr(u8)]
        pub enum $Name {
            #[doc = $first_doc] #[default] $First = $first_value,
            $(#[doc = $doc] $Variant = $value,)+
        }

        impl $crate::bytes::Field for $Name {
            const LEN: usize = 1;

            #[inline]
            fn read(reader: &mut $crate::bytes::Reader<'_>) -> Result<Self, $crate::wire::Error> {
                match reader.get::<u8>()? {
                    $first_value => Ok(Self::$First),
                    $($value => Ok(Self::$Variant),)+
                    _ => Err(reader.out_of_range($field)),
                }
            }

            #[inline]
            fn write(&self, writer: &mut $crate::bytes::Writer<'_>) {
                writer.put(&(*self as u8));
            }
        }
    };
}

/// A number with a type of its own is laid out as the number.
#[macro_export]
macro_rules! newtype {
    ($Name:ident) => {
        impl $crate::bytes::Field for $Name {
            const LEN: usize = size_of::<Self>();

            #[inline]
            fn read(reader: &mut $crate::bytes::Reader<'_>) -> Result<Self, $crate::wire::Error> {
                reader.get().map(Self)
            }

            #[inline]
            fn write(&self, writer: &mut $crate::bytes::Writer<'_>) {
                writer.put(&self.0);
            }
        }
    };
}

pub use crate::{byte_enum, layout, newtype};
