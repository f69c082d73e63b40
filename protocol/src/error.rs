//! Why bytes are not a message of version 1: the error that every layout gives.

use core::fmt;

/// The version this crate speaks: byte 0 of every datagram, now and in every version to come.
pub const VERSION: u8 = 1;

/// Why bytes are not a message of version 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// A message is shorter or longer than its layout.
    Length {
        /// Which message.
        message: &'static str,
        /// Bytes its layout has.
        wanted: usize,
        /// Bytes there were.
        got: usize,
    },
    /// The first byte names a version this crate does not speak.
    UnknownVersion {
        /// The version found.
        version: u8,
    },
    /// The kind byte names no message of version 1.
    UnknownKind {
        /// The kind found.
        kind: u8,
    },
    /// A byte or bit that version 1 reserves is not 0.
    Reserved {
        /// In which message.
        message: &'static str,
    },
    /// A number is infinite or NaN.
    NotFinite {
        /// In which message.
        message: &'static str,
    },
    /// A field holds a value that version 1 gives no meaning.
    OutOfRange {
        /// In which message.
        message: &'static str,
        /// Which field.
        field: &'static str,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { message, wanted, got } => write!(f, "{message}: {got} bytes where {wanted} belong"),
            Self::UnknownVersion { version } => {
                write!(f, "version {version} is spoken here, this end speaks {VERSION}")
            }
            Self::UnknownKind { kind } => write!(f, "kind {kind} is no message of version {VERSION}"),
            Self::Reserved { message } => write!(f, "{message}: a reserved byte or flag is not 0"),
            Self::NotFinite { message } => write!(f, "{message}: a number is infinite or NaN"),
            Self::OutOfRange { message, field } => write!(f, "{message}: {field} has a value without a meaning"),
        }
    }
}

impl core::error::Error for Error {}
