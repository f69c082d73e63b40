//! The first byte: no datagram is two things at once, and none is read as what it is not.

use std::time::Instant;

use cohold_homes::frame::{Frame, Join, LONGEST, Welcome};
use cohold_homes::place::Place;
use cohold_homes::stun;
use cohold_protocol::key::Key;
use cohold_protocol::wire::VERSION;

/// A message of STUN of so many bytes, of this type.
pub(crate) fn stun_of(kind: u16, length: usize, transaction: [u8; 12]) -> Vec<u8> {
    let [size, kind] = [(length - 20) as u16, kind].map(u16::to_be_bytes);
    let mut message = [&kind[..], &size, &[0x21, 0x12, 0xA4, 0x42], &transaction].concat();
    // One attribute, SOFTWARE, fills it.
    if length >= 24 {
        message.extend([0x80, 0x22]);
        message.extend(((length - 24) as u16).to_be_bytes());
    }
    message.resize(length, b' ');
    message
}

#[test]
fn every_first_byte_is_one_thing_at_the_most() {
    let mut rng = 1_u64;
    let mut next = || {
        rng = rng.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (rng >> 56) as u8
    };
    for first in 0..=255_u8 {
        for length in 0..=LONGEST + 8 {
            let mut bytes: Vec<u8> = (0..length).map(|_| next()).collect();
            if let Some(byte) = bytes.first_mut() {
                *byte = first;
            }
            let is = Frame::of(&bytes);
            let may = match first {
                _ if length == 0 => Frame::Unknown,
                // Noise has the cookie of STUN once in four billion.
                0 | 1 => Frame::Unknown,
                VERSION => Frame::Sealed,
                0xF1 if length == Join::LEN => Frame::Join,
                0xF2 if length == Welcome::LEN => Frame::Welcome,
                0xF3 => Frame::Signal,
                0xF4 => Frame::Agreement,
                _ => Frame::Unknown,
            };
            assert_eq!(is, may, "first byte {first}, {length} bytes");
        }
    }
}

#[test]
fn a_message_of_stun_is_none_of_the_wire_and_the_wire_none_of_stun() {
    // All types of STUN: 14 bits.
    for kind in 0..1 << 14 {
        let message = stun_of(kind, 44, [7; 12]);
        let is = Frame::of(&message);
        // Only methods up to 0xFF in their high bits begin with 0 or 1, and binding is one; no type at all is of the wire.
        assert_eq!(is == Frame::Stun, kind >> 8 <= 1, "type {kind:#x}");
        assert!(is != Frame::Sealed || kind >> 8 == u16::from(VERSION));
    }
    let mut message = stun_of(1, 44, [7; 12]);
    for first in [VERSION, 0xF1, 0xF2, 0xF3, 0xF4] {
        message[0] = first;
        assert!(!stun::is_message(&message[..20]) && Frame::of(&message) != Frame::Stun, "{first}");
    }
}

#[test]
fn joins_and_welcomes_are_read_as_they_were_written() {
    let join = Join { side: 1, seat: [1; 32], other: [7; 16], cookie: [2; 16], proof: [3; 16], nonce: [4; 8] };
    assert_eq!(Join::parse(&join.emit()), Some(join));
    for seen in ["203.0.113.9:1234", "[2001:db8::9]:1"] {
        let seen = seen.parse().unwrap();
        let welcome =
            Welcome { seated: true, other: false, refused: true, cookie: [5; 16], place: [8; 32], nonce: [6; 8], seen };
        assert_eq!(Welcome::parse(&welcome.emit()), Some(welcome));
    }
}

#[test]
fn stun_answers_as_rfc_5769_has_it() {
    // Section 2.2: 192.0.2.1, port 32853; section 2.3: 2001:db8:1234:5678:11:2233:4455:6677, the same port.
    let transaction = [0xB7, 0xE7, 0xA7, 0x01, 0xBC, 0x34, 0xD6, 0x86, 0xFA, 0x87, 0xDF, 0xAE];
    let request = stun_of(1, 64, transaction);
    let v4 = stun::answer("192.0.2.1:32853".parse().unwrap(), &request).expect("an answer");
    assert_eq!(v4[..8], [1, 1, 0, 12, 0x21, 0x12, 0xA4, 0x42]);
    assert_eq!(v4[8..20], transaction);
    assert_eq!(v4[20..], [0, 0x20, 0, 8, 0, 1, 0xA1, 0x47, 0xE1, 0x12, 0xA6, 0x43]);
    let v6 =
        stun::answer("[2001:db8:1234:5678:11:2233:4455:6677]:32853".parse().unwrap(), &request).expect("an answer");
    let mapped = [
        0, 0x20, 0, 0x14, 0, 2, 0xA1, 0x47, 1, 0x13, 0xA9, 0xFA, 0xA5, 0xD3, 0xF1, 0x79, 0xBC, 0x25, 0xF4, 0xB5, 0xBE,
        0xD2, 0xB9, 0xD9,
    ];
    assert_eq!(v6[20..], mapped);
}

#[test]
fn whatever_comes_makes_a_meeting_place_send_less_than_it_got() {
    let (now, from) = (Instant::now(), "198.51.100.1:9".parse().unwrap());
    let mut place = Place::new(&Key::new([1; 32]), now);
    let mut rng = 7_u64;
    for round in 0..200_000_u64 {
        rng = rng.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let length = 20 + 4 * (rng >> 58) as usize;
        let kind = [1, 0x101, 0x11, 3][(rng >> 40) as usize % 4];
        let mut datagram = stun_of(kind, length, [round as u8; 12]);
        match (rng >> 32) % 4 {
            0 => {
                let (seat, nonce) = ([round as u8; 32], [0; 8]);
                datagram = Join { side: 0, seat, other: [1; 16], cookie: [9; 16], proof: [0; 16], nonce }.emit().into();
            }
            1 => datagram[0] = (rng >> 16) as u8,
            _ => {}
        }
        let mut sent = 0;
        place.hear(now, from, &datagram, &mut |to, bytes| {
            assert_eq!(to, from);
            sent += bytes.len();
        });
        assert!(sent <= datagram.len(), "{sent} bytes for {}", datagram.len());
        assert!(sent == 0 || sent < datagram.len() || datagram[0] < 2, "a join gets less than it has");
    }
    assert_eq!(place.rooms(), 0, "nothing is kept of who has sent no cookie back");
}
