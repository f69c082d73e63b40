//! Records: objects and regions as bytes of fixed length, each with its own checksum.
//!
//! A checksum is the first 8 bytes of `D(0³², "record", bytes)` (`FORMAT.md`): it finds accidents, not enemies.

use cohold_protocol::bytes::{Reader, Writer};
use cohold_protocol::key::Key;
use cohold_protocol::wire::{Error, Part};

use super::shape::{Bounds, Refused, Shape};

/// Why bytes are no record.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum RecordError {
    /// The bytes are not what was summed up.
    #[error("the checksum of a record is wrong")]
    Checksum,
    /// There is no shape of this kind.
    #[error("there is no shape of kind {0}")]
    UnknownKind(u8),
    /// A number of the shape is out of its range.
    #[error(transparent)]
    Refused(Refused),
    /// The bytes do not have the layout.
    #[error(transparent)]
    Wire(#[from] Error),
}

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

/// The record that `fields` make, ended by its checksum.
fn record<const N: usize>(name: &'static str, fields: impl FnOnce(&mut Writer<'_>)) -> Result<[u8; N], Error> {
    let mut record = [0; N];
    let mut writer = Writer::new(&mut record, name);
    fields(&mut writer);
    writer.end()?;
    if let Some((bytes, sum)) = record.split_last_chunk_mut::<8>() {
        *sum = checksum(bytes);
    }
    Ok(record)
}

/// One thing in a world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Object {
    /// Never given to another object of the same world, and the same on every server.
    pub id: u32,
    /// Changes whenever the shape does.
    pub version: u32,
    /// Shape of the object, with its numbers.
    pub shape: Shape,
}

impl Object {
    /// Bytes of a record.
    pub const LEN: usize = Part::OBJECT_LEN;

    /// The object as a record of fixed length.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn emit(&self) -> Result<[u8; Self::LEN], Error> {
        record("object", |writer| {
            writer.put(&self.id);
            writer.put(&self.version);
            writer.bytes(&[self.shape.kind(), 0, 0, 0]);
            writer.put(&self.shape.numbers());
        })
    }

    /// Reads an object from its record.
    ///
    /// # Errors
    /// A wrong checksum, an unknown kind of shape, or a number that is out of its range.
    pub fn parse(record: &[u8; Self::LEN]) -> Result<Self, RecordError> {
        let mut reader = Reader::exact(checked(record)?, "object", Self::LEN - 8)?;
        let (id, version, kind) = (reader.get()?, reader.get()?, reader.get()?);
        reader.zeros_to(12)?;
        let numbers = reader.get()?;
        let shape = Shape::build(kind, &numbers).ok_or(RecordError::UnknownKind(kind))?;
        let shape = shape.map_err(RecordError::Refused)?;
        // Unused numbers must be 0, all bits of them: a record has one encoding only.
        let used = Shape::ALL.iter().find(|(_, known, _)| *known == kind).map_or(0, |(_, _, fields)| fields.len());
        if numbers.iter().skip(used).any(|unused| unused.to_bits() != 0) {
            return Err(reader.reserved().into());
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
    /// The space that the region covers.
    pub bounds: Bounds,
}

impl Region {
    /// Bytes of a record.
    pub const LEN: usize = Part::REGION_LEN;

    /// The region as a record of fixed length.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn emit(&self) -> Result<[u8; Self::LEN], Error> {
        record("region", |writer| {
            writer.bytes(&[self.id, self.server, 0, 0]);
            writer.put(&self.bounds);
        })
    }

    /// Reads a region from its record.
    ///
    /// # Errors
    /// A wrong checksum, or a number that is not finite.
    pub fn parse(record: &[u8; Self::LEN]) -> Result<Self, RecordError> {
        let mut reader = Reader::exact(checked(record)?, "region", Self::LEN - 8)?;
        let [id, server] = reader.array()?;
        reader.zeros_to(4)?;
        let bounds: Bounds = reader.get()?;
        reader.zeros_to(Self::LEN - 8)?;
        let ([x, y], [to_x, to_y]) = (bounds.min, bounds.max);
        if x >= to_x || y >= to_y {
            return Err(reader.out_of_range("bounds").into());
        }
        Ok(Self { id, server, bounds })
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
