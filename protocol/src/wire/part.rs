//! Part: a piece of the world, as a client asked for it. Unreliable, and complete in itself: parts come in any order.
//!
//! Records are passed on as they are; [`crate::world`] says what is in them and checks their sums.

use super::Topic;
use crate::bytes::{Reader, Writer, layout};
use crate::error::Error;
use crate::world::{Manifest, Object, Region};

layout! {
    /// Which of 8 objects are in scope, and their checksums.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct Page(68 bytes) {
        /// Bit i: the i-th is in scope.
        0 => mask: u8,
        /// Checksums; 0 where not in scope.
        4 => checksums: [u64; Page::OBJECTS],
    }
}

impl Page {
    /// Objects on a page.
    pub const OBJECTS: usize = 8;
}

/// A piece of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Its number within its topic.
    pub number: u16,
    /// The question's tag.
    pub tag: u8,
    /// Checksum of the whole world.
    pub world: u64,
    /// What it holds.
    pub payload: Payload,
}

/// What a part holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Payload {
    /// What the world is.
    Manifest(Manifest),
    /// A region's record.
    Region([u8; Region::LEN]),
    /// Which of 8 objects are in scope.
    Page(Page),
    /// An object's record.
    Object([u8; Object::LEN]),
}

impl Payload {
    /// What it is about.
    pub fn topic(&self) -> Topic {
        match self {
            Self::Manifest(_) => Topic::Manifest,
            Self::Region(_) => Topic::Region,
            Self::Page(_) => Topic::Page,
            Self::Object(_) => Topic::Object,
        }
    }
}

impl Part {
    /// First byte.
    pub const KIND: u8 = 17;
    /// Bytes before the payload.
    pub const HEAD: usize = 16;
    /// Longest part, bytes.
    pub const MAX_LEN: usize = Self::HEAD + Page::LEN;

    /// Reads a part, which must fill `bytes` exactly.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let topic = Reader::exact(bytes.get(1..2).unwrap_or(&[0]), "part", 1)?.get()?;
        let len = match topic {
            Topic::Manifest => Manifest::LEN,
            Topic::Region => Region::LEN,
            Topic::Page => Page::LEN,
            Topic::Object => Object::LEN,
        };
        let mut reader = Reader::exact(bytes, "part", Self::HEAD + len)?;
        reader.kind(Self::KIND)?;
        reader.get::<Topic>()?;
        let (number, tag) = (reader.get()?, reader.get()?);
        reader.zeros_to(8)?;
        let world = reader.get()?;
        let payload = match topic {
            Topic::Manifest if number != 0 => return Err(reader.out_of_range("number")),
            Topic::Manifest => Payload::Manifest(reader.get()?),
            Topic::Region => Payload::Region(reader.array()?),
            Topic::Page => {
                let page: Page = reader.get()?;
                let strays = page.checksums.iter().enumerate().any(|(at, sum)| *sum != 0 && page.mask >> at & 1 == 0);
                if strays {
                    return Err(reader.reserved());
                }
                Payload::Page(page)
            }
            Topic::Object => Payload::Object(reader.array()?),
        };
        Ok(Self { number, tag, world, payload })
    }

    /// Writes the part to the front of `out` and gives its length.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        let mut writer = Writer::new(out, "part");
        writer.bytes(&[Self::KIND, self.payload.topic() as u8]);
        writer.put(&self.number);
        writer.bytes(&[self.tag, 0, 0, 0]);
        writer.put(&self.world);
        match &self.payload {
            Payload::Manifest(manifest) => writer.put(manifest),
            Payload::Region(record) => writer.bytes(record),
            Payload::Page(page) => writer.put(page),
            Payload::Object(record) => writer.bytes(record),
        }
        writer.end()
    }
}
