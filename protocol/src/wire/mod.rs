//! The wire format, version 4: what every byte of a datagram means. `FORMAT.md` says the same for other languages.
//!
//! A datagram is either a [`Greeting`] (hello or welcome: readable, authenticated by the shared key) or a [`Header`]
//! followed by one sealed [`Message`] and its tag. Everything is little-endian, of fixed layout and without padding that
//! could hide anything: reserved bytes are 0 and lengths are exact, so that a message has one encoding only.
//!
//! **Panic contract**: parsing and emitting never panic and never touch a byte outside the slice they are given, whatever
//! is in it. What does not fit is an [`Error`] that says what was wrong.
//!
//! Offsets in the files of this module count from the first byte of the message; a sealed message begins at byte
//! [`Header::LEN`] of its datagram. **Stable**: within a version no layout changes and what is new gets a new kind;
//! any other change gets a new version byte. Ends of two versions refuse each other ([`Error::UnknownVersion`]).

mod datagram;
mod fixed;
mod flow;
mod varying;
mod world;

pub use datagram::{Challenge, Ephemeral, Greeting, GreetingKind, Header, PeerId, Stamps, TABLES, TableHash};
pub use fixed::{Ack, Goodbye, Moved, Probe, Push, Reply, Telemetry};
pub use flow::{AxisFlow, Flow, Flow2, Flow3, Flows};
pub use varying::{Event, Presence, Sample, Sighting};
pub use world::{Ask, Bits, MAX_OBJECTS, MAX_REGIONS, Manifest, Page, Part, Payload, Scope, Topic};

pub use crate::error::{Error, VERSION};
pub use crate::key::TAG_LEN;

/// What sealing adds to a message, header, stamps and tag, bytes.
pub const SEAL_LEN: usize = Header::LEN + Stamps::LEN + TAG_LEN;

/// Bytes on the wire of a packet of an object that is shared along so many axes: sealed, under UDP (8) and IP version 4 (20).
pub const fn packet_bytes(axes: usize) -> usize {
    SEAL_LEN + Flow::LEN - AxisFlow::LEN + axes * AxisFlow::LEN + 28
}

/// The longest message before sealing.
pub const MAX_MESSAGE: usize = Sample::MAX_LEN;

/// The longest datagram of version 4.
pub const MAX_DATAGRAM: usize = Greeting::TAGGED;

const _: () = assert!(SEAL_LEN + MAX_MESSAGE <= MAX_DATAGRAM && Event::MAX_LEN <= MAX_MESSAGE);
const _: () = assert!(Part::MAX_LEN <= MAX_MESSAGE && Presence::MAX_LEN <= MAX_MESSAGE && Ask::LEN <= MAX_MESSAGE);
const _: () = assert!(Telemetry::LEN <= MAX_MESSAGE && Flow3::LEN <= MAX_MESSAGE);

/// Room for any datagram.
pub type Datagram = [u8; MAX_DATAGRAM];

macro_rules! kinds {
    ({ $($Flow:ident, $flow:literal;)+ } $($Kind:ident, $meaning:literal;)+) => {
        /// What a sealed datagram holds; the first byte says which.
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[allow(clippy::large_enum_variant)] // 96 bytes on the way to the caller, and nowhere else.
        pub enum Message { $(#[doc = $flow] $Flow($Flow),)+ $(#[doc = $meaning] $Kind($Kind),)+ }

        impl Message {
            /// Reads one message, which must fill `bytes` exactly.
            ///
            /// # Errors
            /// An unknown kind, a wrong length, a reserved byte that is not 0, or a field without a meaning.
            pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
                match bytes.first().copied() {
                    $(Some($Flow::KIND) => $Flow::parse(bytes).map(Self::$Flow),)+
                    $(Some($Kind::KIND) => $Kind::parse(bytes).map(Self::$Kind),)+
                    Some(kind) => Err(Error::UnknownKind(kind)),
                    None => Err(Error::length("message", 1, 0)),
                }
            }

            /// Writes the message to the front of `out` and gives its length, bytes.
            ///
            /// # Errors
            /// Too little room in `out`, or a number that is not finite.
            pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
                match self {
                    $(Self::$Flow(message) => message.emit(out),)+
                    $(Self::$Kind(message) => message.emit(out),)+
                }
            }
        }

        $(impl From<$Kind> for Message {
            fn from(message: $Kind) -> Self {
                Self::$Kind(message)
            }
        })+
    };
}

kinds! {
    {
        Flow, "The coordination flow, once each packet period.";
        Flow2, "The same of two shared axes.";
        Flow3, "The same of three.";
    }
    Telemetry, "How the sender is doing.";
    Event, "Something that happens once and must arrive.";
    Ack, "Which events have arrived.";
    Probe, "What time is it at your end?";
    Reply, "The answer to a probe.";
    Goodbye, "The sender ends the session.";
    Ask, "A client wants parts of the world.";
    Part, "A part of the world.";
    Presence, "Where clients are.";
    Sample, "What an instrument saw.";
    Push, "What a client does to the shared object.";
    Moved, "The shared object as it is moved.";
}
