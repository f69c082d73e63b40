//! What can be read of a datagram: a greeting (hello or welcome), authenticated by the shared key, or the header of a sealed one.

use crate::bytes::{Reader, byte_enum, emit, layout, newtype};
use crate::error::{Error, VERSION};
use crate::key::{TAG_LEN, Tag};

/// Number of a peer within the installation; the two ends of a link have different numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct PeerId(pub u8);

newtype!(PeerId);

layout! {
    /// The readable part of a sealed datagram. It is authenticated together with what it heads: 16 bytes, then the sealed message,
    /// then a tag of 16 bytes. Kinds 1 and 2 are greetings.
    pub struct Header(16 bytes, version VERSION, kind 3) {
        2 => from: PeerId, "Who sent it.";
        3 => to: PeerId, "For whom it is.";
        4 => session: u32, "Which session's keys seal it.";
        8 => sequence: u64, "Place in the sender's order, and the nonce.";
    }
}

/// What every sealed message begins with: when it was sealed, what of the receiver's was known by then, and what the sender says of the
/// lease. A receiver that finds a time of its own here knows that the message is no older than that, whatever the sender's clock says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stamps {
    /// The sender's clock when it sealed this, µs; at least 1, below 2⁵⁶ (two thousand years).
    pub sealed_us: u64,
    /// How many zeros follow the message, at most 127: they hide what kind it is.
    pub padding: u8,
    /// The same time of the receiver's newest sealed datagram that the sender has opened in this session, µs; 0: none yet.
    pub echo_us: u64,
    /// Word of an operator's end, or what a board tells of its motors ([`crate::lease`]). 0 between peers.
    pub lease: u8,
}

impl Stamps {
    /// Length of the stamps, bytes.
    pub const LEN: usize = 16;
    /// Most zeros that can follow a message.
    pub const MAX_PADDING: usize = 127;
    /// Bits of a time.
    pub(crate) const CLOCK: u64 = (1 << 56) - 1;

    /// Reads the stamps at the front of what was sealed.
    ///
    /// # Errors
    /// A wrong length, or more padding than there may be.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let [first, second]: [u64; 2] = Reader::exact(bytes, "stamps", Self::LEN)?.get()?;
        let [padding, lease] = [first, second].map(|word| (word >> 56) as u8);
        if usize::from(padding) > Self::MAX_PADDING {
            return Err(Error::Reserved("stamps"));
        }
        Ok(Self { sealed_us: first & Self::CLOCK, padding, echo_us: second & Self::CLOCK, lease })
    }

    /// Writes the stamps to the front of `out` and gives their length, bytes.
    ///
    /// # Errors
    /// Too little room in `out`.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        let word = |time: u64, byte: u8| time & Self::CLOCK | u64::from(byte) << 56;
        let padding = self.padding.min(Self::MAX_PADDING as u8);
        emit(&[word(self.sealed_us, padding), word(self.echo_us, self.lease)], "stamps", out)
    }
}

impl Header {
    /// Takes a sealed datagram apart: header as bytes and as fields, and the sealed rest with its tag.
    ///
    /// # Errors
    /// Too few bytes, or a header that is none of this version.
    pub fn parse(datagram: &mut [u8]) -> Result<(Self, &[u8; Self::LEN], &mut [u8]), Error> {
        let least = Error::length("sealed", Self::LEN + TAG_LEN, datagram.len());
        if datagram.len() < Self::LEN + TAG_LEN {
            return Err(least);
        }
        let (head, sealed) = datagram.split_first_chunk_mut::<{ Self::LEN }>().ok_or(least)?;
        let header = Reader::exact(head, "header", Self::LEN)?.get()?;
        Ok((header, head, sealed))
    }

    /// Writes the header to the front of `out` and gives its length, bytes.
    ///
    /// # Errors
    /// Too little room in `out`.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        emit(self, "header", out)
    }
}

/// Most tables of parameters that a greeting can name.
pub const TABLES: usize = 16;

/// 16 bytes that nobody could foresee.
pub type Challenge = [u8; 16];

/// What a sender puts into the keys of a session.
pub type Ephemeral = [u8; 32];

/// The first bytes of the hash of a table of parameters.
pub type TableHash = [u8; 6];

byte_enum! {
    /// The two kinds of greeting.
    pub enum GreetingKind("kind") {
        1 => Hello, "Wants a session; asks for a welcome.";
        2 => Welcome, "Answers a hello.";
    }
}

layout! {
    /// One step of the handshake: what is declared here, then a tag over it of 16 bytes, 200 in all. The handshake makes and
    /// checks the tag and says what challenges and ephemerals do.
    pub struct Greeting(184 bytes, version VERSION) {
        1 => kind: GreetingKind, "Hello or welcome.";
        2 => from: PeerId, "Who sent it.";
        3 => to: PeerId, "For whom it is.";
        4 => line: u32, "Which of a server's clients this is about ([`crate::key::Key::line`]); 0 between two peers.";
        8 => challenge: Challenge, "The sender's challenge.";
        24 => echo: Challenge, "The receiver's challenge as the sender knows it; 0 if it does not.";
        40 => incarnation: u64,
            "Drawn when the sender started: a different one means that it has forgotten everything.";
        48 => ephemeral: Ephemeral, "What the sender puts into the keys of its next session.";
        80 => count: u8 where |count| usize::from(*count) <= TABLES, "How many of `tables` are in use.";
        88 => tables: [TableHash; TABLES], "Hash of each table of parameters; 0 where unused.";
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
    ///
    /// # Errors
    /// A wrong length, or a field without a meaning.
    pub fn parse(datagram: &[u8]) -> Result<(Self, &[u8], &Tag), Error> {
        let mut reader = Reader::exact(datagram, "greeting", Self::TAGGED)?;
        let greeting: Self = reader.get()?;
        if greeting.tables.iter().skip(usize::from(greeting.count)).any(|unused| *unused != TableHash::default()) {
            return Err(reader.reserved());
        }
        let (body, tag) = datagram.split_last_chunk().ok_or(reader.length())?;
        Ok((greeting, body, tag))
    }

    /// Writes everything but the tag to the front of `out` and gives its length, [`Greeting::LEN`].
    ///
    /// # Errors
    /// Too little room in `out`.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        emit(self, "greeting", out)
    }
}
