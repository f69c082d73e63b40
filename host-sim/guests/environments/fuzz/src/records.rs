//! Any bytes as an object's record, a region's and the image of a key, with and without the right checksum: no panic, one
//! encoding only, and nothing that is out of range.

use blake2::digest::{KeyInit, Mac};
use cohold_environments::records::{Object, Region, Shape};
use cohold_protocol::key::{Key, Role};

/// The bytes as a record of `N` whose checksum is right, as FORMAT.md says.
fn summed<const N: usize>(mut record: [u8; N]) -> [u8; N] {
    let mut mac = blake2::Blake2sMac256::new(&[0; 32].into());
    mac.update(b"record\0\0\0\0\0\0\0\0\0\0");
    mac.update(&record[..N - 8]);
    record[N - 8..].copy_from_slice(&mac.finalize().into_bytes()[..8]);
    record
}

fn record<const N: usize>(bytes: &[u8]) -> [u8; N] {
    std::array::from_fn(|at| bytes.get(at).copied().unwrap_or(0))
}

/// Runs one fuzz input through the record parsers.
pub(super) fn run(bytes: &[u8]) {
    for record in [record(bytes), summed(record(bytes))] {
        let Ok(object) = Object::parse(&record) else { continue };
        assert_eq!(object.emit(), Ok(record));
        let (_, _, fields) = Shape::ALL.iter().find(|(_, kind, _)| *kind == record[8]).expect("a kind there is");
        for (field, number) in fields.iter().zip(object.shape.numbers()) {
            assert!((field.min..=field.max).contains(&number), "{} = {number}", field.name);
        }
        let bounds = object.shape.bounds();
        assert!([0, 1].iter().all(|axis| bounds.min[*axis] <= bounds.max[*axis]));
    }
    for record in [record(bytes), summed(record(bytes))] {
        let Ok(region) = Region::parse(&record) else { continue };
        assert_eq!(region.emit(), Ok(record));
        assert!(region.holds(region.bounds.min) && !region.holds(region.bounds.max));
    }
    let image = record(bytes);
    for role in [Role::Peers, Role::Operator] {
        if let Some(key) = Key::from_image(&image, role) {
            assert_eq!(key.image(role), image);
        }
    }
}
