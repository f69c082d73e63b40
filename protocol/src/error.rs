//! Why bytes are not a message of version 1: the error that every layout gives.

/// The version this crate speaks: byte 0 of every datagram, now and in every version to come.
pub const VERSION: u8 = 1;

/// Why bytes are not a message of version 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// A message is shorter or longer than its layout.
    #[error("{message}: {got} bytes where {wanted} belong")]
    Length {
        /// Which message.
        message: &'static str,
        /// Bytes its layout has.
        wanted: usize,
        /// Bytes there were.
        got: usize,
    },
    /// The first byte names a version this crate does not speak.
    #[error("version {version} is spoken here, this end speaks {VERSION}")]
    UnknownVersion {
        /// The version found.
        version: u8,
    },
    /// The kind byte names no message of version 1.
    #[error("kind {kind} is no message of version {VERSION}")]
    UnknownKind {
        /// The kind found.
        kind: u8,
    },
    /// A byte or bit that version 1 reserves is not 0.
    #[error("{message}: a reserved byte or flag is not 0")]
    Reserved {
        /// In which message.
        message: &'static str,
    },
    /// A number is infinite or NaN.
    #[error("{message}: a number is infinite or NaN")]
    NotFinite {
        /// In which message.
        message: &'static str,
    },
    /// A field holds a value that version 1 gives no meaning.
    #[error("{message}: {field} has a value without a meaning")]
    OutOfRange {
        /// In which message.
        message: &'static str,
        /// Which field.
        field: &'static str,
    },
}
