//! Ask and part: a client wants parts of the world that its server holds, and gets them. Unreliable: parts come in any order, each
//! complete in itself, and what does not come is asked for again. The manifest is number 0.
//!
//! Records are passed on as they are; what is in them, and whether their sums are right, is for whoever holds a world.

use crate::bytes::{Reader, Writer, byte_enum, layout, newtype};
use crate::error::Error;

/// Most objects of a world.
pub const MAX_OBJECTS: usize = 4096;
/// Most regions of a world.
pub const MAX_REGIONS: usize = 32;

/// A part of the world, chosen by place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Scope {
    /// All of the world.
    #[default]
    All,
    /// What comes within a radius of a point.
    Around {
        /// Of the point, m.
        x: f32,
        /// Of the point, m.
        y: f32,
        /// 0 or more, m.
        radius: f32,
    },
    /// One region and the margin around it.
    Region(u8),
}

layout! {
    /// What a world is, before any of it is known.
    pub struct Manifest(12 bytes) {
        0 => version: u32, "Version of the world, for people.";
        4 => objects: u16 where |objects| usize::from(*objects) <= MAX_OBJECTS, "How many objects.";
        6 => regions: u8 where |regions| usize::from(*regions) <= MAX_REGIONS, "How many regions.";
        8 => margin_m: f32 where |margin_m| margin_m.is_sign_positive(), "How far beyond its region a server knows, m.";
    }
}

/// 256 yes or no.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bits(pub [u8; Bits::LEN]);

impl Bits {
    /// Length of the set, bytes.
    pub const LEN: usize = 32;
    /// Number of bits in the set.
    pub const COUNT: usize = 8 * Self::LEN;

    /// Whether bit `at` is set; beyond the last it is not.
    pub fn has(&self, at: usize) -> bool {
        self.0.get(at / 8).is_some_and(|byte| byte >> (at % 8) & 1 == 1)
    }

    /// Sets bit `at`; beyond the last, nothing.
    pub fn set(&mut self, at: usize) {
        if let Some(byte) = self.0.get_mut(at / 8) {
            *byte |= 1 << (at % 8);
        }
    }

    /// The bits that are set, in order.
    pub fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        (0..Self::COUNT).filter(|at| self.has(*at))
    }
}

newtype!(Bits);

byte_enum! {
    /// The kind of part that is asked for or sent.
    pub enum Topic("topic") {
        0 => Manifest, "What the world is: version, checksum, how many objects and regions.";
        1 => Region, "Regions, by number.";
        2 => Page, "Which of 8 objects are in scope, and their checksums.";
        3 => Object, "Objects, by their place in the order of ids.";
    }
}

/// A question about the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ask {
    /// The kind of part that is asked for.
    pub topic: Topic,
    /// Number that bit 0 of `wanted` stands for.
    pub first: u16,
    /// The part of the world that this is about.
    pub scope: Scope,
    /// Comes back with every part of the answer, so that one about an older scope is known.
    pub tag: u8,
    /// The set of numbers that are wanted.
    pub wanted: Bits,
}

impl Ask {
    /// First byte, which names the message.
    pub const KIND: u8 = 16;
    /// Length of the message, bytes.
    pub const LEN: usize = 52;

    /// The numbers that are wanted.
    pub fn numbers(&self) -> impl Iterator<Item = usize> + '_ {
        self.wanted.iter().map(|bit| usize::from(self.first) + bit)
    }

    /// Reads a question, which must fill `bytes` exactly.
    ///
    /// # Errors
    /// A wrong length, a reserved byte that is not 0, or a field without a meaning.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let mut reader = Reader::exact(bytes, "ask", Self::LEN)?;
        reader.kind(Self::KIND)?;
        let (topic, first) = (reader.get()?, reader.get()?);
        let [scope, region, tag] = reader.array()?;
        reader.zeros_to(8)?;
        let point: [f32; 3] = reader.get()?;
        // Minus zero is another encoding of zero: only the one with all bits 0 is meant.
        let no_point = point.iter().all(|number| number.to_bits() == 0);
        let scope = match (scope, region, point) {
            (0, 0, _) if no_point => Scope::All,
            (1, 0, [x, y, radius]) if radius.is_sign_positive() => Scope::Around { x, y, radius },
            (2, region, _) if no_point => Scope::Region(region),
            _ => return Err(reader.out_of_range("scope")),
        };
        Ok(Self { topic, first, scope, tag, wanted: reader.get()? })
    }

    /// Writes the question to the front of `out` and gives its length.
    ///
    /// # Errors
    /// Too little room in `out`, or a number that is not finite.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        let (scope, region, point) = match self.scope {
            Scope::All => (0, 0, [0.0; 3]),
            Scope::Around { radius, .. } if !radius.is_sign_positive() => {
                return Err(Error::OutOfRange { message: "ask", field: "scope" });
            }
            Scope::Around { x, y, radius } => (1, 0, [x, y, radius]),
            Scope::Region(region) => (2, region, [0.0; 3]),
        };
        let mut writer = Writer::new(out, "ask");
        writer.bytes(&[Self::KIND, self.topic as u8]);
        writer.put(&self.first);
        writer.bytes(&[scope, region, self.tag, 0]);
        writer.put(&point);
        writer.put(&self.wanted);
        writer.end()
    }
}

layout! {
    /// Eight objects: a mask of those in scope, and their checksums.
    pub struct Page(68 bytes) {
        0 => mask: u8, "Bit i: the i-th is in scope.";
        4 => checksums: [u64; Page::OBJECTS], "Checksums; 0 where not in scope.";
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
    /// Tag of the question that this answers.
    pub tag: u8,
    /// Checksum of the whole world.
    pub world: u64,
    /// Content of the part.
    pub payload: Payload,
}

/// What a part holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Payload {
    /// What the world is.
    Manifest(Manifest),
    /// The record of a region.
    Region([u8; Part::REGION_LEN]),
    /// Mask and checksums of eight objects.
    Page(Page),
    /// The record of an object.
    Object([u8; Part::OBJECT_LEN]),
}

impl Payload {
    /// The kind of part that this is.
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
    /// First byte, which names the message.
    pub const KIND: u8 = 17;
    /// Bytes of the record of an object; what is in it, and its checksum, is for whoever holds a world.
    pub const OBJECT_LEN: usize = 64;
    /// Bytes of the record of a region.
    pub const REGION_LEN: usize = 32;
    /// Bytes before the payload.
    pub const HEAD: usize = 16;
    /// Longest encoded part, bytes.
    pub const MAX_LEN: usize = Self::HEAD + Page::LEN;

    /// Reads a part, which must fill `bytes` exactly.
    ///
    /// # Errors
    /// A wrong length, a reserved byte that is not 0, or a field without a meaning.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let topic = Reader::exact(bytes.get(1..2).unwrap_or(&[0]), "part", 1)?.get()?;
        let len = match topic {
            Topic::Manifest => Manifest::LEN,
            Topic::Region => Self::REGION_LEN,
            Topic::Page => Page::LEN,
            Topic::Object => Self::OBJECT_LEN,
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
    ///
    /// # Errors
    /// Too little room in `out`, or a number that is not finite.
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
