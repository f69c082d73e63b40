//! Records: objects and regions as bytes of fixed length, each with its own checksum.
//!
//! | offset | type | object |
//! |---|---|---|
//! | 0 | u32 | id |
//! | 4 | u32 | version: changes whenever anything else does |
//! | 8 | u8 | kind: 1 wall, 2 body, 3 strip, 4 block |
//! | 9 | u8 × 3 | 0 |
//! | 12 | f32 × 11 | numbers in the order of [`Shape::ALL`], 0 where unused |
//! | 56 | u64 | checksum of bytes 0 to 55 |
//!
//! | offset | type | region |
//! |---|---|---|
//! | 0 | u8 | id |
//! | 1 | u8 | server: who holds it |
//! | 2 | u16 | 0 |
//! | 4 | f32 × 4 | least x, least y, largest x, largest y, m |
//! | 20 | u32 | 0 |
//! | 24 | u64 | checksum of bytes 0 to 23 |
//!
//! A checksum is the first 8 bytes of `D(0³², "record", bytes)` (`FORMAT.md`): it finds accidents, not enemies.

use core::fmt;

use super::{Bounds, Refused, Shape};
use crate::key::Key;
use crate::wire;
use crate::wire::bytes::{Reader, Writer};

/// Why bytes are no record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RecordError {
    /// The bytes are not what was summed up.
    Checksum,
    /// There is no shape of this kind.
    UnknownKind {
        /// The kind found.
        kind: u8,
    },
    /// A number of the shape is out of its range.
    Refused(Refused),
    /// The bytes do not have the layout.
    Wire(wire::Error),
}

impl fmt::Display for RecordError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Checksum => f.write_str("the checksum of a record is wrong"),
            Self::UnknownKind { kind } => write!(f, "there is no shape of kind {kind}"),
            Self::Refused(refused) => refused.fmt(f),
            Self::Wire(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for RecordError {}

impl From<wire::Error> for RecordError {
    fn from(error: wire::Error) -> Self {
        Self::Wire(error)
    }
}

/// The checksum of `bytes`.
fn checksum(bytes: &[u8]) -> [u8; 8] {
    Key::new([0; Key::LEN]).derive("record").with(bytes).first()
}

/// The bytes before the checksum, if it is right.
fn checked(record: &[u8]) -> Result<&[u8], RecordError> {
    match record.split_last_chunk::<8>() {
        Some((bytes, sum)) if checksum(bytes) == *sum => Ok(bytes),
        _ => Err(RecordError::Checksum),
    }
}

/// Ends a record with its checksum.
fn summed<const N: usize>(mut record: [u8; N]) -> [u8; N] {
    if let Some((bytes, sum)) = record.split_last_chunk_mut::<8>() {
        *sum = checksum(bytes);
    }
    record
}

/// One thing in a world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Object {
    /// Never given to another object of the same world, and the same on every server.
    pub id: u32,
    /// Changes whenever the shape does.
    pub version: u32,
    /// What it is made of.
    pub shape: Shape,
}

impl Object {
    /// Bytes of a record.
    pub const LEN: usize = 64;

    /// The record.
    pub fn emit(&self) -> Result<[u8; Self::LEN], wire::Error> {
        let mut record = [0; Self::LEN];
        let head = Writer::new(&mut record, "object")
            .put(&self.id.to_le_bytes())
            .put(&self.version.to_le_bytes())
            .put(&[self.shape.kind(), 0, 0, 0]);
        self.shape.numbers().into_iter().fold(head, Writer::f32).end()?;
        Ok(summed(record))
    }

    /// Reads a record.
    pub fn parse(record: &[u8; Self::LEN]) -> Result<Self, RecordError> {
        let bytes = checked(record)?;
        let mut reader = Reader::exact(bytes, "object", Self::LEN - 8)?;
        let (id, version, kind) = (reader.u32()?, reader.u32()?, reader.u8()?);
        reader.reserved::<3>()?;
        let mut numbers = [0.0; Shape::NUMBERS];
        for number in &mut numbers {
            *number = reader.f32()?;
        }
        reader.end()?;
        let shape = Shape::build(kind, &numbers).ok_or(RecordError::UnknownKind { kind })?;
        let shape = shape.map_err(RecordError::Refused)?;
        // Unused numbers must be 0, all bits of them: a record has one encoding only.
        let used = Shape::ALL.iter().find(|(_, known, _)| *known == kind).map_or(0, |(_, _, fields)| fields.len());
        if numbers.iter().skip(used).any(|unused| unused.to_bits() != 0) {
            return Err(RecordError::Wire(wire::Error::Reserved { message: "object" }));
        }
        Ok(Self { id, version, shape })
    }
}

/// A part of the world that one server holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Number within the world.
    pub id: u8,
    /// Number of the server that holds it.
    pub server: u8,
    /// Where it is.
    pub bounds: Bounds,
}

impl Region {
    /// Bytes of a record.
    pub const LEN: usize = 32;

    /// The record.
    pub fn emit(&self) -> Result<[u8; Self::LEN], wire::Error> {
        let mut record = [0; Self::LEN];
        let ([x, y], [to_x, to_y]) = (self.bounds.min, self.bounds.max);
        Writer::new(&mut record, "region")
            .put(&[self.id, self.server, 0, 0])
            .f32(x)
            .f32(y)
            .f32(to_x)
            .f32(to_y)
            .end()?;
        Ok(summed(record))
    }

    /// Reads a record.
    pub fn parse(record: &[u8; Self::LEN]) -> Result<Self, RecordError> {
        let mut reader = Reader::exact(checked(record)?, "region", Self::LEN - 8)?;
        let [id, server] = reader.array()?;
        reader.reserved::<2>()?;
        let (min, max) = ([reader.f32()?, reader.f32()?], [reader.f32()?, reader.f32()?]);
        reader.reserved::<4>()?;
        reader.end()?;
        let ([x, y], [to_x, to_y]) = (min, max);
        if x >= to_x || y >= to_y {
            return Err(RecordError::Wire(wire::Error::OutOfRange { message: "region", field: "bounds" }));
        }
        Ok(Self { id, server, bounds: Bounds { min, max } })
    }

    /// Whether the point lies in it; the largest x and y belong to the next region.
    pub fn holds(&self, [x, y]: [f32; 2]) -> bool {
        let ([ax, ay], [bx, by]) = (self.bounds.min, self.bounds.max);
        x >= ax && x < bx && y >= ay && y < by
    }

    /// The region and `margin_m` on every side: what its server knows about.
    pub fn with_margin(&self, margin_m: f32) -> Bounds {
        Bounds::around(self.bounds.min, self.bounds.max, margin_m)
    }
}

/// What a world is, before any of it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Manifest {
    /// Version of the world, for people.
    pub version: u32,
    /// How many objects.
    pub objects: u16,
    /// How many regions.
    pub regions: u8,
    /// How far beyond its region a server knows, m.
    pub margin_m: f32,
}

impl Manifest {
    /// Bytes.
    pub const LEN: usize = 12;

    /// The bytes.
    pub fn emit(&self) -> Result<[u8; Self::LEN], wire::Error> {
        let mut bytes = [0; Self::LEN];
        Writer::new(&mut bytes, "manifest")
            .put(&self.version.to_le_bytes())
            .put(&self.objects.to_le_bytes())
            .put(&[self.regions, 0])
            .f32(self.margin_m)
            .end()?;
        Ok(bytes)
    }

    /// Reads the bytes.
    pub fn parse(bytes: &[u8; Self::LEN]) -> Result<Self, wire::Error> {
        let mut reader = Reader::exact(bytes, "manifest", Self::LEN)?;
        let (version, objects, regions) = (reader.u32()?, reader.u16()?, reader.u8()?);
        reader.reserved::<1>()?;
        let manifest = Self { version, objects, regions, margin_m: reader.f32()? };
        reader.end()?;
        if usize::from(objects) > super::MAX_OBJECTS || usize::from(regions) > super::MAX_REGIONS {
            return Err(wire::Error::OutOfRange { message: "manifest", field: "objects or regions" });
        }
        if !manifest.margin_m.is_sign_positive() {
            return Err(wire::Error::OutOfRange { message: "manifest", field: "margin" });
        }
        Ok(manifest)
    }
}
