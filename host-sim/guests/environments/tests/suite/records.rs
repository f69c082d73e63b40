//! The scene database: records byte by byte, what is refused, and which checksum notices what.

use cohold_environments::records::{
    Block, Body, Bounds, Database, Full, MAX_REGIONS, Object, RecordError, Region, Scope, Shape, Strip, Wall, in_scope,
};
use cohold_protocol::wire;
use proptest::prelude::*;

fn objects() -> impl Strategy<Value = Object> {
    let shape = (0..Shape::ALL.len(), prop::collection::vec(0.0..=1.0f64, Shape::NUMBERS)).prop_map(|(at, parts)| {
        let (_, kind, fields) = Shape::ALL[at];
        let mut numbers = [0.0; Shape::NUMBERS];
        for ((number, field), part) in numbers.iter_mut().zip(fields).zip(parts) {
            let value = (f64::from(field.min) + part * f64::from(field.max - field.min)) as f32;
            *number = if field.whole { value.round() } else { value };
        }
        Shape::build(kind, &numbers).unwrap().unwrap()
    });
    (any::<(u32, u32)>(), shape).prop_map(|((id, version), shape)| Object { id, version, shape })
}

proptest! {
    #[test]
    fn what_is_written_is_read(object in objects()) {
        let record = object.emit().unwrap();
        prop_assert_eq!(Object::parse(&record), Ok(object));
    }

    #[test]
    fn any_bit_that_flips_is_noticed(object in objects(), bit in 0..8 * Object::LEN) {
        let mut record = object.emit().unwrap();
        record[bit / 8] ^= 1 << (bit % 8);
        prop_assert_eq!(Object::parse(&record), Err(RecordError::Checksum));
    }

    /// What is read has one encoding only, and nothing panics, even where the checksum happens to be right.
    #[test]
    fn any_bytes(bytes in any::<[[u8; 28]; 2]>(), kind in 0..6u8, object in objects(), from in 0..60usize) {
        // A record's own first bytes and then any, with the right checksum.
        let mut record = object.emit().unwrap();
        for at in from.min(56)..56 {
            record[at] = bytes[at / 28][at % 28];
        }
        record[8] = if from < 8 { kind } else { record[8] };
        resum(&mut record);
        if let Ok(object) = Object::parse(&record) {
            prop_assert_eq!(object.emit().unwrap(), record);
        }
    }
}

/// The checksum as FORMAT.md says, by the reference BLAKE2s of another crate's interface: a keyed digest of 32 bytes.
fn resum(record: &mut [u8]) {
    use blake2::digest::array::Array;
    use blake2::digest::{KeyInit, Mac};
    let (bytes, sum) = record.split_last_chunk_mut::<8>().unwrap();
    let mac =
        blake2::Blake2sMac256::new(&Array([0; 32])).chain_update(b"record\0\0\0\0\0\0\0\0\0\0").chain_update(bytes);
    sum.copy_from_slice(&mac.finalize().into_bytes()[..8]);
}

#[test]
fn literal_bytes() {
    let body = Body { x_m: 1.0, y_m: -0.5, radius_m: 2.5, mass_kg: 1.0, ..Body::default() };
    let object = Object { id: 0x0403_0201, version: 7, shape: Shape::Body(body) };
    let record = object.emit().unwrap();
    assert_eq!(record[..12], [1, 2, 3, 4, 7, 0, 0, 0, 2, 0, 0, 0]);
    assert_eq!(record[12..20], [0, 0, 0x80, 0x3f, 0, 0, 0, 0xbf]);
    assert_eq!(record[28..36], [0, 0, 0x20, 0x40, 0, 0, 0x80, 0x3f]);
    assert_eq!(record[48..56], [0; 8]);
    let block = Block { b_x_m: 2.5, d_y_m: -0.5, ..Block::default() };
    let record = Object { id: 9, version: 0, shape: Shape::Block(block) }.emit().unwrap();
    assert_eq!(record[..12], [9, 0, 0, 0, 0, 0, 0, 0, 4, 0, 0, 0]);
    assert_eq!(record[20..24], [0, 0, 0x20, 0x40]);
    assert_eq!(record[40..44], [0, 0, 0, 0xbf]);
    assert_eq!(record[44..56], [0, 0, 0x7a, 0x44, 0, 0, 0, 0x40, 0, 0, 0, 0]);
    let region = Region { id: 3, server: 2, bounds: Bounds { min: [0.0, -0.5], max: [1.0, 2.5] } };
    let record = region.emit().unwrap();
    assert_eq!(record[..12], [3, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xbf]);
    assert_eq!(Region::parse(&record), Ok(region));
}

#[test]
fn what_is_summed_up_rightly_can_still_be_refused() {
    let object = Object { id: 1, version: 1, shape: Shape::Strip(Strip::default()) };
    let mut record = object.emit().unwrap();
    let with = |record: &mut [u8; 64], at: usize, value: f32| {
        record[at..at + 4].copy_from_slice(&value.to_le_bytes());
        resum(record);
        Object::parse(record)
    };
    // 12 + 4·4: masses.
    let refused = with(&mut record, 28, 2.5).unwrap_err().to_string();
    assert_eq!(refused, "strip.masses = 2.5 is not allowed: it must be a whole number from 1 to 64");
    let refused = with(&mut record, 28, 65.0).unwrap_err().to_string();
    assert!(refused.contains("strip.masses = 65"), "{refused}");
    with(&mut record, 28, 9.0).unwrap();
    let error = with(&mut record, 32, f32::NAN).unwrap_err();
    assert_eq!(error, RecordError::Wire(wire::Error::NotFinite("object")));
    with(&mut record, 32, 0.01).unwrap();
    // The number after a strip's last.
    let error = with(&mut record, 52, 1.0).unwrap_err();
    assert_eq!(error, RecordError::Wire(wire::Error::Reserved("object")));
    with(&mut record, 52, 0.0).unwrap();
    record[8] = 5;
    resum(&mut record);
    assert_eq!(Object::parse(&record), Err(RecordError::UnknownKind(5)));
}

fn body(id: u32, x: f32, y: f32) -> Object {
    Object { id, version: 1, shape: Shape::Body(Body { x_m: x, y_m: y, radius_m: 0.5, ..Body::default() }) }
}

#[test]
fn ids_are_there_once_and_in_order_and_memory_is_bounded() {
    let mut database = Database::<4>::default();
    for id in [9, 2, 5, 2] {
        database.put(body(id, id as f32, 0.0)).unwrap();
    }
    database.put(body(7, 0.0, 0.0)).unwrap();
    assert_eq!(database.put(body(1, 0.0, 0.0)), Err(Full { what: "objects", most: 4 }));
    assert!(database.objects().iter().map(|object| object.id).eq([2, 5, 7, 9]));
    assert_eq!((database.get(5).map(|o| o.id), database.get(6)), (Some(5), None));
    let whole = database.checksum().unwrap();
    database.put(body(5, 5.1, 0.0)).unwrap();
    assert_ne!(database.checksum().unwrap(), whole);
    database.put(body(5, 5.0, 0.0)).unwrap();
    assert_eq!(database.checksum().unwrap(), whole);
    for id in 0..MAX_REGIONS as u8 {
        database.put_region(Region { id, server: 0, bounds: Bounds { min: [0.0; 2], max: [1.0; 2] } }).unwrap();
    }
    let region = Region { id: 32, server: 0, bounds: Bounds { min: [0.0; 2], max: [1.0; 2] } };
    assert_eq!(database.put_region(region), Err(Full { what: "regions", most: 32 }));
}

#[test]
fn scopes_hold_what_touches_them() {
    let region = Region { id: 6, server: 1, bounds: Bounds { min: [0.0, 0.0], max: [10.0, 10.0] } };
    let around = |x: f32, y: f32, radius: f32| Scope::Around { x, y, radius };
    for (scope, x, y, held) in [
        (Scope::All, 900.0, 0.0, true),
        // A body of radius 0.5; its square corner counts as the body.
        (around(0.0, 0.0, 1.0), 1.45, 0.0, true),
        (around(0.0, 0.0, 1.0), 1.55, 0.0, false),
        (around(0.0, 0.0, 1.0), 1.25, 1.25, false),
        (around(0.0, 0.0, 1.0), 1.15, 1.15, true),
        (Scope::Region(6), 5.0, 5.0, true),
        (Scope::Region(6), 12.4, 5.0, true),
        (Scope::Region(6), 12.6, 5.0, false),
        (Scope::Region(5), 5.0, 5.0, false),
    ] {
        let bounds = body(1, x, y).shape.bounds();
        assert_eq!(in_scope(scope, &bounds, &[region], 2.0), held, "{scope:?} {x} {y}");
    }
    let wall = Wall { from_x_m: 2.0, from_y_m: 3.0, to_x_m: -1.0, to_y_m: 4.0, thickness_m: 0.5, ..Wall::default() };
    assert_eq!(Shape::Wall(wall).bounds(), Bounds { min: [-1.5, 2.5], max: [2.5, 4.5] });
}
