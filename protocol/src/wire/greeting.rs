//! Greeting: hello (kind 1, asks for an answer) and welcome (kind 2, is one). Readable, authenticated by the shared key.
//!
//! | offset | type | field | unit |
//! |---|---|---|---|
//! | 0 | u8 | version = 1 | |
//! | 1 | u8 | kind: 1 hello, 2 welcome | |
//! | 2 | u8 | from: the sender's number | |
//! | 3 | u8 | to: the receiver's number | |
//! | 4 | u32 | line: which of a server's clients this is about, 0 between two peers | |
//! | 8 | u8 × 16 | challenge: fresh from the sender, for the receiver to echo | |
//! | 24 | u8 × 16 | echo: the receiver's challenge, 0 if the sender has none | |
//! | 40 | u64 | incarnation: drawn when the sender started | |
//! | 48 | u8 | tables: how many of the hashes below are in use, 0 to 16 | |
//! | 49 | u8 × 7 | 0 | |
//! | 56 | u64 × 16 | hash of each table of parameters, 0 where unused | |
//! | 184 | u8 × 16 | tag over bytes 0 to 183 | |
//!
//! 200 bytes. [`crate::handshake`] makes and checks the tag and says what the two challenges do.

use super::bytes::{Reader, Writer};
use super::header::PeerId;
use super::{Error, TAG_LEN, VERSION};

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

/// One step of the handshake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Greeting {
    /// Hello or welcome.
    pub kind: GreetingKind,
    /// Who sent it.
    pub from: PeerId,
    /// For whom it is.
    pub to: PeerId,
    /// Which of a server's clients this is about ([`crate::key::Key::line`]); 0 between two peers.
    pub line: u32,
    /// The sender's challenge.
    pub challenge: Challenge,
    /// The receiver's challenge as the sender knows it; 0 if it does not.
    pub echo: Challenge,
    /// Drawn when the sender started: a different one means that it has forgotten everything.
    pub incarnation: u64,
    /// How many of `tables` are in use.
    pub count: u8,
    /// Hash of each table of parameters; 0 where unused.
    pub tables: [u64; TABLES],
}

impl Greeting {
    /// Bytes, tag included.
    pub const LEN: usize = 200;
    /// Bytes that the tag covers.
    pub const BODY: usize = Self::LEN - TAG_LEN;

    /// Whether the second byte of a datagram names a greeting.
    pub fn is_kind(kind: u8) -> bool {
        kind == GreetingKind::Hello as u8 || kind == GreetingKind::Welcome as u8
    }

    /// Takes a greeting apart: fields, the bytes the tag covers, and the tag, which is **not** checked here.
    pub fn parse(datagram: &[u8]) -> Result<(Self, &[u8], &[u8; TAG_LEN]), Error> {
        let mut reader = Reader::exact(datagram, "greeting", Self::LEN)?;
        let version = reader.u8()?;
        if version != VERSION {
            return Err(Error::UnknownVersion { version });
        }
        let kind = match reader.u8()? {
            1 => GreetingKind::Hello,
            2 => GreetingKind::Welcome,
            kind => return Err(Error::UnknownKind { kind }),
        };
        let (from, to) = (PeerId(reader.u8()?), PeerId(reader.u8()?));
        let line = reader.u32()?;
        let (challenge, echo) = (reader.array()?, reader.array()?);
        let incarnation = reader.u64()?;
        let count = reader.u8()?;
        if usize::from(count) > TABLES {
            return Err(Error::OutOfRange { message: "greeting", field: "tables" });
        }
        reader.reserved::<7>()?;
        let mut tables = [0; TABLES];
        for table in &mut tables {
            *table = reader.u64()?;
        }
        if tables.iter().skip(usize::from(count)).any(|unused| *unused != 0) {
            return Err(Error::Reserved { message: "greeting" });
        }
        let greeting = Self { kind, from, to, line, challenge, echo, incarnation, count, tables };
        reader.array::<TAG_LEN>()?;
        reader.end()?;
        let length = Error::Length { message: "greeting", wanted: Self::LEN, got: datagram.len() };
        let (body, tag) = datagram.split_last_chunk().ok_or(length)?;
        Ok((greeting, body, tag))
    }

    /// Writes everything but the tag to the front of `out` and gives its length, [`Greeting::BODY`].
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        let mut writer = Writer::new(out, "greeting")
            .put(&[VERSION, self.kind as u8, self.from.0, self.to.0])
            .put(&self.line.to_le_bytes())
            .put(&self.challenge)
            .put(&self.echo)
            .put(&self.incarnation.to_le_bytes())
            .put(&[self.count])
            .put(&[0; 7]);
        for table in &self.tables {
            writer = writer.put(&table.to_le_bytes());
        }
        writer.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Greeting {
        let mut tables = [0; TABLES];
        tables[0] = 0x0102_0304_0506_0708;
        tables[1] = u64::MAX;
        Greeting {
            kind: GreetingKind::Welcome,
            from: PeerId(1),
            to: PeerId(2),
            line: 0x0403_0201,
            challenge: [0xaa; 16],
            echo: [0xbb; 16],
            incarnation: 0x1122_3344_5566_7788,
            count: 2,
            tables,
        }
    }

    #[test]
    fn literal_bytes() {
        let mut bytes = [0; Greeting::LEN];
        bytes[..8].copy_from_slice(&[1, 2, 1, 2, 1, 2, 3, 4]);
        bytes[8..24].fill(0xaa);
        bytes[24..40].fill(0xbb);
        bytes[40..48].copy_from_slice(&[0x88, 0x77, 0x66, 0x55, 0x44, 0x33, 0x22, 0x11]);
        bytes[48] = 2;
        bytes[56..64].copy_from_slice(&[8, 7, 6, 5, 4, 3, 2, 1]);
        bytes[64..72].fill(0xff);
        let mut out = [0; Greeting::LEN];
        assert_eq!(sample().emit(&mut out), Ok(Greeting::BODY));
        assert_eq!(out, bytes);
        bytes[184..].fill(0x77);
        assert_eq!(Greeting::parse(&bytes), Ok((sample(), &bytes[..184], &[0x77; 16])));
    }

    #[test]
    fn refuses_more_tables_than_there_is_room_for() {
        let mut out = [0; Greeting::LEN];
        Greeting { count: 17, ..sample() }.emit(&mut out).unwrap();
        assert_eq!(Greeting::parse(&out), Err(Error::OutOfRange { message: "greeting", field: "tables" }));
        Greeting { count: 1, ..sample() }.emit(&mut out).unwrap();
        assert_eq!(Greeting::parse(&out), Err(Error::Reserved { message: "greeting" }));
    }
}
