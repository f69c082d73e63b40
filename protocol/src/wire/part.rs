//! Part: a piece of the world, as a client asked for it. Unreliable, and complete in itself: parts come in any order.
//!
//! | offset | type | field | unit |
//! |---|---|---|---|
//! | 0 | u8 | kind = 17 | |
//! | 1 | u8 | topic: 0 manifest, 1 region, 2 page, 3 object | |
//! | 2 | u16 | number: of the region, page or object; 0 for the manifest | |
//! | 4 | u8 | tag, as the question had it | |
//! | 5 | u8 × 3 | 0 | |
//! | 8 | u64 | world: checksum of the whole world that this is a part of | |
//! | 16 | … | payload | |
//!
//! | payload | bytes | fields |
//! |---|---|---|
//! | manifest | 12 | u32 version, u16 objects, u8 regions, u8 0, f32 margin (m) |
//! | region | 32 | a region's record |
//! | page | 68 | u8 mask (bit i: object 8·number + i is in scope), u8 × 3 0, u64 × 8 their checksums, 0 where not in scope |
//! | object | 64 | an object's record |
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literal_bytes() {
        let manifest = Manifest { version: 3, objects: 0x0201, regions: 2, margin_m: 0.5 };
        let part = Part { number: 0, tag: 9, world: 0x0807_0605_0403_0201, payload: Payload::Manifest(manifest) };
        let bytes = [
            17, 0, 0, 0, 9, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, // head
            3, 0, 0, 0, 1, 2, 2, 0, 0, 0, 0, 0x3f, // manifest
        ];
        let mut out = [0; Part::MAX_LEN];
        assert_eq!(part.emit(&mut out), Ok(28));
        assert_eq!(out[..28], bytes);
        assert_eq!(Part::parse(&bytes), Ok(part));

        let mut page = Page { mask: 0b101, ..Page::default() };
        (page.checksums[0], page.checksums[2]) = (1, 0x0203);
        let part = Part { number: 5, tag: 0, world: 0, payload: Payload::Page(page) };
        assert_eq!(part.emit(&mut out), Ok(84));
        assert_eq!((&out[..5], &out[16..21], &out[36..38]), (&[17, 2, 5, 0, 0][..], &[5, 0, 0, 0, 1][..], &[3, 2][..]));
        assert_eq!(Part::parse(&out), Ok(part));
        out[28] = 1; // a checksum of an object that is not in scope
        assert_eq!(Part::parse(&out), Err(Error::Reserved { message: "part" }));
    }

    #[test]
    fn refuses_other_topics_and_lengths() {
        let mut bytes = [0; Part::HEAD + Object::LEN];
        bytes[..2].copy_from_slice(&[Part::KIND, 3]);
        assert!(Part::parse(&bytes).is_ok());
        assert_eq!(Part::parse(&bytes[..79]).unwrap_err(), Error::Length { message: "part", wanted: 80, got: 79 });
        bytes[1] = 4;
        assert_eq!(Part::parse(&bytes), Err(Error::OutOfRange { message: "part", field: "topic" }));
    }
}
