//! A second implementation of the keys and the sealing, from FORMAT.md alone: what a holder of the key can say that a `Link`
//! never would. Tests of the board use it, too.

use blake2::digest::Mac;
use blake2::digest::consts::U16;
use blake2::{Blake2sMac, Blake2sMac256};
use chacha20poly1305::ChaCha20Poly1305;
use chacha20poly1305::aead::{AeadInOut, KeyInit};
use x25519_dalek::{X25519_BASEPOINT_BYTES, x25519};

/// Byte 0 of every datagram.
const VERSION: u8 = 4;
/// Bytes of a greeting, of a sealed datagram's header and of a tag.
pub(crate) const GREETING: usize = 200;
const HEADER: usize = 16;
const TAG: usize = 16;

/// `D(k, label, data)`.
fn derive(key: &[u8; 32], label: &str, data: &[&[u8]]) -> [u8; 32] {
    let mut padded = [0; 16];
    padded[..label.len()].copy_from_slice(label.as_bytes());
    let mut mac = <Blake2sMac256 as KeyInit>::new(&(*key).into());
    mac.update(&padded);
    data.iter().for_each(|part| mac.update(part));
    mac.finalize().into_bytes().into()
}

/// A hello that answers `heard`, a greeting of the other end with this line and these tables, with this ephemeral secret.
pub(crate) fn hello(key: &[u8; 32], heard: &[u8], secret: [u8; 32]) -> Vec<u8> {
    hello_with(key, heard, x25519(secret, X25519_BASEPOINT_BYTES))
}

/// The same with any ephemeral.
pub(crate) fn hello_with(key: &[u8; 32], heard: &[u8], ephemeral: [u8; 32]) -> Vec<u8> {
    let mut hello = heard.to_vec();
    hello[1] = 1;
    hello.swap(2, 3);
    hello[8..24].fill(0x44);
    hello[24..40].copy_from_slice(&heard[8..24]);
    hello[40..48].fill(0x55);
    hello[48..80].copy_from_slice(&ephemeral);
    let (body, tag) = hello.split_at_mut(GREETING - TAG);
    let greeting_key = derive(key, "greeting", &[&body[2..4]]);
    let mut mac = <Blake2sMac<U16> as KeyInit>::new(&greeting_key.into());
    mac.update(body);
    tag.copy_from_slice(&mac.finalize().into_bytes());
    hello
}

/// The session of two greetings.
pub(crate) struct Session {
    secret: [u8; 32],
    /// As it stands in the header.
    pub(crate) number: [u8; 4],
}

impl Session {
    /// Of two greetings, one from each end, whose ephemerals are the session's; the second one's secret is this.
    pub(crate) fn of(key: &[u8; 32], one: &[u8], two: &[u8], secret: [u8; 32]) -> Self {
        let mut theirs = [0; 32];
        theirs.copy_from_slice(&one[48..80]);
        let agreed = x25519(secret, theirs);
        let (low, high) = if one[2] < two[2] { (one, two) } else { (two, one) };
        let parts = [
            &[VERSION, low[2], high[2]],
            &low[48..80],
            &high[48..80],
            &low[40..48],
            &high[40..48],
            &agreed,
            &low[80..81],
            &low[88..184],
        ];
        let secret = derive(key, "session", &parts);
        let number = derive(&secret, "number", &[]);
        Self { secret, number: [number[0], number[1], number[2], number[3]] }
    }

    fn cipher(&self, from: u8, to: u8, sequence: u64) -> (ChaCha20Poly1305, [u8; 12]) {
        let direction = derive(&self.secret, "direction", &[&[from, to]]);
        let key = derive(&direction, "epoch", &[&(sequence >> 20).to_le_bytes()]);
        let mut nonce = [0; 12];
        nonce[4..].copy_from_slice(&sequence.to_le_bytes());
        (ChaCha20Poly1305::new(&key.into()), nonce)
    }

    /// Any bytes, sealed, with the time and the echo that they begin with, µs.
    pub(crate) fn seal(&self, from: u8, to: u8, sequence: u64, [at, echo]: [u64; 2], message: &[u8]) -> Vec<u8> {
        let head = [&[VERSION, 3, from, to][..], &self.number, &sequence.to_le_bytes()].concat();
        let (cipher, nonce) = self.cipher(from, to, sequence);
        let mut body = [&at.to_le_bytes(), &echo.to_le_bytes(), message].concat();
        let tag = cipher.encrypt_inout_detached(&nonce.into(), &head, body.as_mut_slice().into());
        [&head[..], &body, &tag.expect("a short message")].concat()
    }

    /// What is sealed in a datagram of this session: time, echo, message.
    pub(crate) fn open(&self, datagram: &[u8]) -> Option<([u64; 2], Vec<u8>)> {
        let (head, rest) = datagram.split_at_checked(HEADER)?;
        let (body, tag) = rest.split_last_chunk::<TAG>()?;
        let sequence = u64::from_le_bytes(head[8..16].try_into().ok()?);
        let (cipher, nonce) = self.cipher(head[2], head[3], sequence);
        let mut body = body.to_vec();
        let opened = cipher.decrypt_inout_detached(&nonce.into(), head, body.as_mut_slice().into(), &(*tag).into());
        let number = |at: usize| body.get(at..at + 8)?.try_into().ok().map(u64::from_le_bytes);
        let sealed = ([number(0)?, number(8)?], body.get(16..)?.to_vec());
        (head[..2] == [VERSION, 3] && head[4..8] == self.number && opened.is_ok()).then_some(sealed)
    }
}
