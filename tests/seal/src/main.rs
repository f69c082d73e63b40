//! Sealing and opening with both ciphers of `protocol/src/cipher`, beside ring with a key that it keeps and beside openssl.
//!
//! `cargo run --release` in this folder prints the time of each in ns, for messages of the wire's lengths under 16 bytes of
//! header: the least of 25 rounds, so that what else the machine does is left out. openssl is asked by its own command, if that
//! is there, and then only for a flow; it seals without a header. The portable cipher's backends are those that
//! `.cargo/config.toml` chooses, as for everything in this repository.

use std::hint::black_box;
use std::process::Command;
use std::time::Instant;

use cohold_protocol::cipher::{portable, ring as rings};
use cohold_protocol::key::Key;
use ring::aead::{Aad, CHACHA20_POLY1305, LessSafeKey, Nonce, UnboundKey};

/// Calls in a round.
const CALLS: u64 = 20_000;
/// Messages of the wire, bytes: an acknowledgement, a flow, a telemetry, a record, and the two of them with stamps of 16.
const LENGTHS: [usize; 6] = [12, 40, 56, 92, 108, 168];
const HEAD: [u8; 16] = [1; 16];
const KEY: [u8; 32] = [7; 32];

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

/// Time of sealing `length` bytes by openssl's own command, ns; `None` without it.
fn openssl(length: usize) -> Option<f64> {
    let arguments = ["speed", "-seconds", "2", "-mr", "-evp", "chacha20-poly1305", "-bytes", &length.to_string()];
    let said = Command::new("openssl").args(arguments).output().ok()?;
    // The last line ends with bytes a second.
    let rate = String::from_utf8_lossy(&said.stdout).lines().last()?.rsplit(':').next()?.parse::<f64>().ok()?;
    Some(1e9 * length as f64 / rate)
}

fn main() {
    let (portable, ours) = (portable::Cipher::new(&Key::new(KEY)), rings::Cipher::new(&Key::new(KEY)));
    let kept = LessSafeKey::new(UnboundKey::new(&CHACHA20_POLY1305, &KEY).expect("a key"));
    let ring_nonce = |number| Nonce::assume_unique_for_key(nonce(number));
    println!("                  seal, ns                           open, ns");
    println!("bytes  portable    on PCs  ring     ratio  portable    on PCs  ring     ratio");
    for length in LENGTHS {
        let mut message = [0x5a; 256];
        let message = &mut message[..length];
        let seal = [
            time(|call| _ = black_box(portable.seal(nonce(call), &HEAD, message).expect("sealed"))),
            time(|call| _ = black_box(ours.seal(nonce(call), &HEAD, message).expect("sealed"))),
            time(|call| {
                let tag = kept.seal_in_place_separate_tag(ring_nonce(call), Aad::from(&HEAD), message);
                black_box(tag.expect("sealed").as_ref()[0]);
            }),
        ];
        let tag = ours.seal(nonce(1), &HEAD, message).expect("sealed");
        let mut opened = message.to_vec();
        // What is opened was there before: each has it copied first.
        let open = [
            time(|_| {
                opened.copy_from_slice(message);
                portable.open(nonce(1), &HEAD, &mut opened, tag).expect("authentic");
                black_box(opened[0]);
            }),
            time(|_| {
                opened.copy_from_slice(message);
                ours.open(nonce(1), &HEAD, &mut opened, tag).expect("authentic");
                black_box(opened[0]);
            }),
            time(|_| {
                opened.copy_from_slice(message);
                let body =
                    kept.open_in_place_separate_tag(ring_nonce(1), Aad::from(&HEAD), tag.into(), &mut opened, 0..);
                black_box(body.expect("authentic")[0]);
            }),
        ];
        print!("{length:5}");
        for [portable, ours, kept] in [seal, open] {
            print!(" {portable:9.0} {ours:9.0} {kept:5.0} {:9.2}", ours / kept);
        }
        println!();
    }
    match openssl(40) {
        Some(ns) => println!("openssl seals 40 bytes in {ns:.0} ns"),
        None => println!("there is no openssl to ask"),
    }
}
