//! Sealing and opening with ChaCha20-Poly1305 as `protocol/src/session.rs` does it, beside ring's, in one run.
//!
//! `cargo run --release` in this folder prints the time of each in ns, for messages of the wire's lengths under 16 bytes of
//! header: the least of 25 rounds, so that what else the machine does is left out. The backends are those that
//! `.cargo/config.toml` chooses, as for everything in this repository.

use std::hint::black_box;
use std::time::Instant;

use chacha20poly1305::aead::{AeadInOut, KeyInit, array::Array};
use chacha20poly1305::{ChaCha20Poly1305, Tag};
use ring::aead::{Aad, CHACHA20_POLY1305, LessSafeKey, Nonce, UnboundKey};

/// Calls in a round.
const CALLS: u64 = 20_000;
/// Messages of the wire, bytes: an acknowledgement, a flow, a telemetry, a record, and the two of them with stamps of 16.
const LENGTHS: [usize; 6] = [12, 40, 56, 92, 108, 168];
const HEAD: [u8; 16] = [1; 16];

/// ns of a call, the least of 25 rounds.
fn time(mut call: impl FnMut(u64)) -> f64 {
    let round = |_| {
        let start = Instant::now();
        (0..CALLS).for_each(&mut call);
        start.elapsed().as_nanos() as f64 / CALLS as f64
    };
    (0..25).map(round).fold(f64::INFINITY, f64::min)
}

fn nonce(number: u64) -> [u8; 12] {
    let mut nonce = [0; 12];
    nonce[4..].copy_from_slice(&number.to_le_bytes());
    nonce
}

fn main() {
    let ours = ChaCha20Poly1305::new(&Array([7; 32]));
    let theirs = LessSafeKey::new(UnboundKey::new(&CHACHA20_POLY1305, &[7; 32]).expect("a key"));
    println!("bytes      seal      ring     ratio      open      ring     ratio");
    for length in LENGTHS {
        let mut message = [0x5a; 256];
        let message = &mut message[..length];
        let seal = time(|call| {
            black_box(ours.encrypt_inout_detached(&Array(nonce(call)), &HEAD, (&mut *message).into()).expect("sealed"));
        });
        let ring_seal = time(|call| {
            let nonce = Nonce::assume_unique_for_key(nonce(call));
            black_box(theirs.seal_in_place_separate_tag(nonce, Aad::from(&HEAD), message).expect("sealed").as_ref()[0]);
        });
        let tag = ours.encrypt_inout_detached(&Array(nonce(1)), &HEAD, (&mut *message).into()).expect("sealed");
        let sealed = [&message[..], &tag].concat();
        let mut opened = sealed.clone();
        let open = time(|_| {
            opened.copy_from_slice(&sealed);
            let (body, tag) = opened.split_at_mut(length);
            let tag = Tag::try_from(&*tag).expect("a tag");
            ours.decrypt_inout_detached(&Array(nonce(1)), &HEAD, body.into(), &tag).expect("authentic");
            black_box(body[0]);
        });
        let ring_open = time(|_| {
            opened.copy_from_slice(&sealed);
            let nonce = Nonce::assume_unique_for_key(nonce(1));
            black_box(theirs.open_in_place(nonce, Aad::from(&HEAD), &mut opened).expect("authentic")[0]);
        });
        let ratios = [seal / ring_seal, open / ring_open];
        println!(
            "{length:5} {seal:9.0} {ring_seal:9.0} {:9.2} {open:9.0} {ring_open:9.0} {:9.2}",
            ratios[0], ratios[1]
        );
    }
}
