//! Scene database: objects and regions of a world, with ids, versions and checksums, in bounded memory.
//!
//! Every server of a world holds the same objects under the same ids, at least those of its own regions and a margin
//! around them; so two servers agree about what lies on their border. Positions are in one plane, in metres.
//!
//! **Invariants**: objects and regions are in order of their ids; an id is there once. **Sizes**: 64 bytes of record an
//! object, 32 a region; a [`Database`] of `N` objects takes about 60·N bytes and no heap.
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

mod record;
mod shape;

use heapless::Vec;

pub use cohold_protocol::wire::{MAX_OBJECTS, MAX_REGIONS, Manifest, Scope};
pub use record::{Object, RecordError, Region};
pub use shape::{Block, Body, Bounds, Field, Refused, Shape, Strip, Wall};

use cohold_protocol::{bytes, key::Key, wire::Error};

/// Whether an object with these bounds is in scope.
pub fn in_scope(scope: Scope, bounds: &Bounds, regions: &[Region], margin_m: f32) -> bool {
    match scope {
        Scope::All => true,
        Scope::Around { x, y, radius } => bounds.within([x, y], radius),
        Scope::Region(id) => regions.iter().any(|region| region.id == id && region.with_margin(margin_m).meets(bounds)),
    }
}

/// There is no room for another object or region in a database.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no room for more than {most} {what}")]
pub struct Full {
    /// The things that there are too many of: objects or regions.
    pub what: &'static str,
    /// The number for which there is room.
    pub most: usize,
}

/// A world, or what is known of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Database<const OBJECTS: usize> {
    /// Version of the world, for people.
    pub version: u32,
    /// How far beyond its region a server knows, m.
    pub margin_m: f32,
    objects: Vec<Object, OBJECTS>,
    regions: Vec<Region, MAX_REGIONS>,
}

impl<const OBJECTS: usize> Database<OBJECTS> {
    /// Adds an object, or replaces the one with its id.
    ///
    /// # Errors
    /// There is no room for another object.
    pub fn put(&mut self, object: Object) -> Result<(), Full> {
        let most = OBJECTS.min(MAX_OBJECTS);
        put(&mut self.objects, object, |known| known.id, most).map_err(|_| Full { what: "objects", most })
    }

    /// Adds a region, or replaces the one with its id.
    ///
    /// # Errors
    /// There is no room for another region.
    pub fn put_region(&mut self, region: Region) -> Result<(), Full> {
        let most = MAX_REGIONS;
        put(&mut self.regions, region, |known| known.id, most).map_err(|_| Full { what: "regions", most })
    }

    /// Takes out every object for which `keep` is false.
    pub fn retain(&mut self, keep: impl FnMut(&Object) -> bool) {
        self.objects.retain(keep);
    }

    /// Every object, by id.
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// Every region, by id.
    pub fn regions(&self) -> &[Region] {
        &self.regions
    }

    /// The object with this id.
    pub fn get(&self, id: u32) -> Option<&Object> {
        self.objects.get(self.objects.binary_search_by_key(&id, |known| known.id).ok()?)
    }

    /// The first part that a client gets: what the world is.
    pub fn manifest(&self) -> Manifest {
        Manifest {
            version: self.version,
            objects: u16::try_from(self.objects.len()).unwrap_or(u16::MAX),
            regions: u8::try_from(self.regions.len()).unwrap_or(u8::MAX),
            margin_m: self.margin_m,
        }
    }

    /// Checksum of the whole: the first 8 bytes of `D(0³², "world", manifest ‖ region records ‖ object records)`.
    ///
    /// # Errors
    /// A number of the world that is not finite.
    pub fn checksum(&self) -> Result<u64, Error> {
        world_checksum(&self.manifest(), &self.regions, &self.objects)
    }
}

/// Puts `new` where its id belongs, in place of the one that has it; gives it back where there are `most` already.
fn put<T, I: Ord, const N: usize>(all: &mut Vec<T, N>, new: T, id: impl Fn(&T) -> I, most: usize) -> Result<(), T> {
    match all.binary_search_by_key(&id(&new), id) {
        Ok(at) => {
            if let Some(known) = all.get_mut(at) {
                *known = new;
            }
            Ok(())
        }
        Err(_) if all.len() >= most => Err(new),
        Err(at) => all.insert(at, new),
    }
}

/// Checksum of a world that is put together from its pieces, each in order of ids.
pub(crate) fn world_checksum<'a>(
    manifest: &Manifest,
    regions: impl IntoIterator<Item = &'a Region>,
    objects: impl IntoIterator<Item = &'a Object>,
) -> Result<u64, Error> {
    let mut known = [0; Manifest::LEN];
    bytes::emit(manifest, "manifest", &mut known)?;
    let mut sum = Key::new([0; Key::LEN]).derive("world").with(&known);
    for region in regions {
        sum = sum.with(&region.emit()?);
    }
    for object in objects {
        sum = sum.with(&object.emit()?);
    }
    Ok(u64::from_le_bytes(sum.first()))
}

/// The checksum that ends a record.
pub(crate) fn checksum_of(record: &[u8]) -> u64 {
    record.last_chunk().map_or(0, |sum| u64::from_le_bytes(*sum))
}
