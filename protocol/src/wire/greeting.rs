//! Greeting: hello (asks for an answer) and welcome (is one). Readable, authenticated by the shared key: what is declared below,
//! then a tag over it of 16 bytes, 200 in all. [`crate::handshake`] makes and checks the tag and says what the two challenges do.

use super::header::PeerId;
use crate::bytes::{Field, Reader, Writer, emit, layout};
use crate::error::{Error, VERSION};
use crate::key::TAG_LEN;

/// Most tables of parameters that a greeting can name.
pub const TABLES: usize = 16;

/// 16 bytes that nobody could foresee.
pub type Challenge = [u8; 16];

/// Hello or welcome.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GreetingKind {
    /// Wants a session; asks for a welcome.
    Hello = 1,
    /// Answers a hello.
    Welcome = 2,
}

impl Field for GreetingKind {
    const LEN: usize = 1;

    fn read(reader: &mut Reader<'_>) -> Result<Self, Error> {
        match reader.get()? {
            1 => Ok(Self::Hello),
            2 => Ok(Self::Welcome),
            kind => Err(Error::UnknownKind { kind }),
        }
    }

    fn write(&self, writer: &mut Writer<'_>) {
        writer.put(&(*self as u8));
    }
}

layout! {
    /// One step of the handshake.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct Greeting(184 bytes, version VERSION) {
        /// Hello or welcome.
        1 => kind: GreetingKind,
        /// Who sent it.
        2 => from: PeerId,
        /// For whom it is.
        3 => to: PeerId,
        /// Which of a server's clients this is about ([`crate::key::Key::line`]); 0 between two peers.
        4 => line: u32,
        /// The sender's challenge.
        8 => challenge: Challenge,
        /// The receiver's challenge as the sender knows it; 0 if it does not.
        24 => echo: Challenge,
        /// Drawn when the sender started: a different one means that it has forgotten everything.
        40 => incarnation: u64,
        /// How many of `tables` are in use.
        48 => count: u8 where |count| usize::from(*count) <= TABLES,
        /// Hash of each table of parameters; 0 where unused.
        56 => tables: [u64; TABLES],
    }
}

impl Greeting {
    /// Bytes with the tag.
    pub const TAGGED: usize = Self::LEN + TAG_LEN;

    /// Whether the second byte of a datagram names a greeting.
    pub fn is_kind(kind: u8) -> bool {
        kind == GreetingKind::Hello as u8 || kind == GreetingKind::Welcome as u8
    }

    /// Takes a greeting apart: fields, the bytes the tag covers, and the tag, which is **not** checked here.
    pub fn parse(datagram: &[u8]) -> Result<(Self, &[u8], &[u8; TAG_LEN]), Error> {
        let mut reader = Reader::exact(datagram, "greeting", Self::TAGGED)?;
        let greeting: Self = reader.get()?;
        if greeting.tables.iter().skip(usize::from(greeting.count)).any(|unused| *unused != 0) {
            return Err(reader.reserved());
        }
        let (body, tag) = datagram.split_last_chunk().ok_or(reader.length())?;
        Ok((greeting, body, tag))
    }

    /// Writes everything but the tag to the front of `out` and gives its length, [`Greeting::LEN`].
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        emit(self, "greeting", out)
    }
}
