//! Ask: a client wants parts of the world that its server holds. Unreliable: what does not come is asked for again.
//!
//! 52 bytes. The manifest is number 0.

use crate::bytes::{Reader, Writer, byte_enum, newtype};
use crate::error::Error;
use crate::world::Scope;

/// 256 yes or no.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bits(pub [u8; Bits::LEN]);

impl Bits {
    /// Bytes.
    pub const LEN: usize = 32;
    /// Bits.
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
    /// What is asked for, or told.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Topic("topic") {
        /// What the world is: version, checksum, how many objects and regions.
        #[default]
        Manifest = 0,
        /// Regions, by number.
        Region = 1,
        /// Which of 8 objects are in scope, and their checksums.
        Page = 2,
        /// Objects, by their place in the order of ids.
        Object = 3,
    }
}

/// A question about the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ask {
    /// What is asked for.
    pub topic: Topic,
    /// Number that bit 0 of `wanted` stands for.
    pub first: u16,
    /// Which part of the world this is about.
    pub scope: Scope,
    /// Comes back with every part of the answer, so that one about an older scope is known.
    pub tag: u8,
    /// Which numbers are wanted.
    pub wanted: Bits,
}

impl Ask {
    /// First byte.
    pub const KIND: u8 = 16;
    /// Bytes.
    pub const LEN: usize = 52;

    /// The numbers that are wanted.
    pub fn numbers(&self) -> impl Iterator<Item = usize> + '_ {
        self.wanted.iter().map(|bit| usize::from(self.first) + bit)
    }

    /// Reads a question, which must fill `bytes` exactly.
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
