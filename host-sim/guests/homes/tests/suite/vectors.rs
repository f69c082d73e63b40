//! Bytes of a meeting as a second implementation makes them (`vectors.py`, written from FORMAT.md alone).

use std::time::Instant;

use cohold_homes::agreement::{Accepter, Heard, Inviter, code};
use cohold_homes::frame::{Join, Welcome};
use cohold_homes::seat::Seat;
use cohold_protocol::key::Key;

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn bytes(hex: &str) -> [u8; 32] {
    std::array::from_fn(|at| u8::from_str_radix(&hex[2 * at..2 * at + 2], 16).expect("hexadecimal digits"))
}

#[test]
fn a_join_shows_the_secret_key_of_its_seat_as_format_md_has_it() {
    let (now, mut seat) = (Instant::now(), Seat::new(&Key::new([7; 32]), 1, &Key::new([3; 32])));
    let first = Join::parse(&seat.poll(now, false).expect("it is due")).expect("a join");
    assert_eq!((first.side, first.cookie, first.proof), (1, [0; 16], [0; 16]));
    assert_eq!(hex(&first.seat), "895c1de75385c88a33550b9af1882ebd46f722a3c1b4c6f079ed9d4b63f80c3c");
    assert_eq!(hex(&first.other), "cb06d7bddf8e0ec5827d1c296bd2a733");
    assert_eq!(hex(&first.room()), "a5d49f88a6d369afbf2a2f4d88136818");
    let place = bytes("88149f775fb7ae8236421a6d3ffe6ddaad13219d4d3353427dd69384484f5b38");
    let (cookie, seen) = (std::array::from_fn(|at| at as u8), "203.0.113.9:1234".parse().expect("an address"));
    let (seated, other, refused) = (false, false, true);
    let welcome = Welcome { seated, other, refused, cookie, place, nonce: first.nonce, seen }.emit();
    assert_eq!(seat.hear(now, &welcome), Some(true));
    let again = seat.poll(now, false).expect("it is due at once");
    let head = "f101895c1de75385c88a33550b9af1882ebd46f722a3c1b4c6f079ed9d4b63f80c3ccb06d7bddf8e0ec5827d1c296bd2a733";
    assert_eq!(hex(&again[..82]), format!("{head}000102030405060708090a0b0c0d0e0fc4c8c01611e8fea84a85dd6fe9bc28b1"));
    let parts = ["f204", &hex(&cookie), &hex(&place), &hex(&first.nonce), "d20400000000000000000000ffffcb007109"];
    assert_eq!(hex(&welcome), parts.concat());
}

#[test]
fn link_agreement_and_code_are_as_format_md_has_them() {
    let now = Instant::now();
    let mut inviter = Inviter::new("203.0.113.1:4000", &Key::new([1; 32]), now);
    assert_eq!(inviter.invite.link(), "haptic://203.0.113.1:4000/wparnhtg6vgwrwibqnuwlbq6uqpco");
    let offer = Accepter::new(&inviter.invite, &Key::new([2; 32])).offer();
    assert_eq!(
        hex(&offer),
        "f4017e18c89d9259502c83340982f9372e3410f75fdf1c3197346ee38428d626b150d2daf234eaacf63222126c714decc7fd"
    );
    let (answer, heard) = inviter.hear(now, &offer);
    assert_eq!(
        hex(&answer.expect("an answer")),
        "f4021df9f4dd5d92456db2892484ece035a8d9dfdb4f2a47f271432674e5c652c71ac60c64f9016d876b1ec4c6e6933b0598"
    );
    let key = Key::new(bytes("37ae7f146995bee63084f802fc68bb6daa5896b082bba342753924147346c67f"));
    assert_eq!(code(&key), "750 402");
    assert_eq!(heard, Heard::Agreed(key));
}
