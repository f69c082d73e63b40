//! The wire format, version 1: what every byte of a datagram means. `FORMAT.md` says the same for other languages.
//!
//! A datagram is either a [`Greeting`] (hello or welcome: readable, authenticated by the shared key) or a [`Header`]
//! followed by one sealed [`Message`] and its tag. Everything is little-endian, of fixed layout and without padding that
//! could hide anything: reserved bytes are 0 and lengths are exact, so that a message has one encoding only.
//!
//! **Panic contract**: parsing and emitting never panic and never touch a byte outside the slice they are given, whatever
//! is in it. What does not fit is an [`Error`] that says what was wrong.
//!
//! Offsets in the files of this module count from the first byte of the message; a sealed message begins at byte
//! [`Header::LEN`] of its datagram. **Stable from version 1**: a layout is never changed, a new one gets a new kind, and a
//! change of meaning gets a new version byte.

use core::fmt;

mod ack;
mod ask;
pub(crate) mod bytes;
mod event;
mod flow;
mod goodbye;
mod greeting;
mod header;
mod moved;
mod part;
mod presence;
mod probe;
mod push;
mod reply;
mod sample;
mod telemetry;

pub use ack::Ack;
pub use ask::{Ask, Bits, Topic};
pub use event::Event;
pub use flow::Flow;
pub use goodbye::Goodbye;
pub use greeting::{Challenge, Greeting, GreetingKind, TABLES};
pub use header::{Header, PeerId};
pub use moved::Moved;
pub use part::{Page, Part, Payload};
pub use presence::{Presence, Sighting};
pub use probe::Probe;
pub use push::Push;
pub use reply::Reply;
pub use sample::Sample;
pub use telemetry::Telemetry;

/// The version this crate speaks: byte 0 of every datagram, now and in every version to come.
pub const VERSION: u8 = 1;

/// Bytes of the authentication tag that ends every datagram.
pub const TAG_LEN: usize = 16;
/// What sealing adds to a message, header and tag, bytes.
pub const SEAL_LEN: usize = Header::LEN + TAG_LEN;

/// The longest message before sealing.
pub const MAX_MESSAGE: usize = Telemetry::LEN;

/// The longest datagram of version 1.
pub const MAX_DATAGRAM: usize = Greeting::LEN;

const _: () = assert!(Header::LEN + MAX_MESSAGE + TAG_LEN <= MAX_DATAGRAM && Event::MAX_LEN <= MAX_MESSAGE);
const _: () = assert!(Part::MAX_LEN <= MAX_MESSAGE && Presence::MAX_LEN <= MAX_MESSAGE && Ask::LEN <= MAX_MESSAGE);
const _: () = assert!(Sample::MAX_LEN <= MAX_MESSAGE);

/// Room for any datagram.
pub type Datagram = [u8; MAX_DATAGRAM];

/// What a sealed datagram holds; the first byte says which.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant)] // 92 bytes on the way to the caller, and nowhere else.
pub enum Message {
    /// The coordination flow, once each packet period.
    Flow(Flow),
    /// How the sender is doing.
    Telemetry(Telemetry),
    /// Something that happens once and must arrive.
    Event(Event),
    /// Which events have arrived.
    Ack(Ack),
    /// What time is it at your end?
    Probe(Probe),
    /// The answer to a probe.
    Reply(Reply),
    /// The sender ends the session.
    Goodbye(Goodbye),
    /// A client wants parts of the world.
    Ask(Ask),
    /// A part of the world.
    Part(Part),
    /// Where clients are.
    Presence(Presence),
    /// What an instrument saw.
    Sample(Sample),
    /// What a client does to the shared object.
    Push(Push),
    /// The shared object as it is moved.
    Moved(Moved),
}

impl Message {
    /// Reads one message, which must fill `bytes` exactly.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        match bytes.first().copied() {
            Some(Flow::KIND) => Flow::parse(bytes).map(Self::Flow),
            Some(Telemetry::KIND) => Telemetry::parse(bytes).map(Self::Telemetry),
            Some(Event::KIND) => Event::parse(bytes).map(Self::Event),
            Some(Ack::KIND) => Ack::parse(bytes).map(Self::Ack),
            Some(Probe::KIND) => Probe::parse(bytes).map(Self::Probe),
            Some(Reply::KIND) => Reply::parse(bytes).map(Self::Reply),
            Some(Goodbye::KIND) => Goodbye::parse(bytes).map(Self::Goodbye),
            Some(Ask::KIND) => Ask::parse(bytes).map(Self::Ask),
            Some(Part::KIND) => Part::parse(bytes).map(Self::Part),
            Some(Presence::KIND) => Presence::parse(bytes).map(Self::Presence),
            Some(Sample::KIND) => Sample::parse(bytes).map(Self::Sample),
            Some(Push::KIND) => Push::parse(bytes).map(Self::Push),
            Some(Moved::KIND) => Moved::parse(bytes).map(Self::Moved),
            Some(kind) => Err(Error::UnknownKind { kind }),
            None => Err(Error::Length { message: "message", wanted: 1, got: 0 }),
        }
    }

    /// Writes the message to the front of `out` and gives its length.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        match self {
            Self::Flow(flow) => flow.emit(out),
            Self::Telemetry(telemetry) => telemetry.emit(out),
            Self::Event(event) => event.emit(out),
            Self::Ack(ack) => ack.emit(out),
            Self::Probe(probe) => probe.emit(out),
            Self::Reply(reply) => reply.emit(out),
            Self::Goodbye(goodbye) => goodbye.emit(out),
            Self::Ask(ask) => ask.emit(out),
            Self::Part(part) => part.emit(out),
            Self::Presence(presence) => presence.emit(out),
            Self::Sample(sample) => sample.emit(out),
            Self::Push(push) => push.emit(out),
            Self::Moved(moved) => moved.emit(out),
        }
    }
}

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
