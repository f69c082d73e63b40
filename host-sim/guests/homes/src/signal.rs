//! Signals: what one carrier says to the other, sealed, by both paths: that a path lives, how long it takes, and where else its end may be reached.
//!
//! Each run of an end draws an **instance**, 16 random bytes, and seals with a key of its own, made of the shared key, its side and the instance; a counter is the
//! nonce. What is believed of a signal echoes the reader's own instance: nothing of an earlier run counts, whoever repeats it. On each path
//! counters only grow, so that nothing counts twice.

use std::net::SocketAddr;

use cohold_protocol::cipher::Cipher;
use cohold_protocol::key::{Key, NONCE_LEN, TAG_LEN};

use crate::frame::{ADDRESS, Bytes, SIGNAL, address_bytes, address_of};

/// Most addresses that a signal names.
pub(crate) const MOST_ADDRESSES: usize = 6;
/// First byte, instance, counter.
const HEAD: usize = 1 + 16 + 8;
const FIXED: usize = 2 + 4 + 8 + 8 + 4 + 16;
/// Longest signal, bytes.
pub(crate) const MOST: usize = HEAD + FIXED + MOST_ADDRESSES * (1 + ADDRESS) + TAG_LEN;
const _: () = assert!(MOST <= crate::frame::LONGEST);

const HEARS: u8 = 1;
const DIRECT: u8 = 2;

/// 16 bytes drawn by a run of an end.
pub(crate) type Instance = [u8; 16];

/// What is said.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Signal {
    /// The sender hears the reader directly.
    pub(crate) hears: bool,
    /// It is said by the direct path.
    pub(crate) direct: bool,
    /// How often ICE has begun.
    pub(crate) generation: u8,
    /// Place among the signals of this path.
    pub(crate) count: u32,
    /// The sender's clock, µs.
    pub(crate) sent_us: u64,
    /// The reader's clock as the newest signal of this path told it, µs; 0: none yet.
    pub(crate) echo_us: u64,
    /// How long ago that came, µs.
    pub(crate) held_us: u32,
    /// The reader's instance, as the sender knows it.
    pub(crate) echo: Instance,
    /// Where the sender may be reached: as seen by others, or as its own machine has it.
    pub(crate) addresses: Vec<(bool, SocketAddr)>,
}

fn cipher(key: &Key, side: u8, instance: &Instance) -> Cipher {
    Cipher::new(&Key::new(key.derive("signal").with(&[side]).with(instance).first()))
}

fn nonce(counter: u64) -> [u8; NONCE_LEN] {
    let mut nonce = [0; NONCE_LEN];
    nonce.iter_mut().zip(counter.to_le_bytes()).for_each(|(to, from)| *to = from);
    nonce
}

/// Seals what this end says.
pub(crate) struct Sealer {
    cipher: Cipher,
    instance: Instance,
    counter: u64,
}

impl Sealer {
    pub(crate) fn new(key: &Key, side: u8, instance: Instance) -> Self {
        Self { cipher: cipher(key, side, &instance), instance, counter: 0 }
    }

    pub(crate) fn seal(&mut self, signal: &Signal) -> Vec<u8> {
        let Signal { hears, direct, generation, count, sent_us, echo_us, held_us, echo, addresses } = signal;
        let flags = if *hears { HEARS } else { 0 } | if *direct { DIRECT } else { 0 };
        self.counter += 1;
        let counter = self.counter.to_le_bytes();
        let mut bytes = [&[SIGNAL][..], &self.instance, &counter].concat();
        bytes.extend([flags, *generation]);
        bytes.extend(count.to_le_bytes());
        bytes.extend(sent_us.to_le_bytes());
        bytes.extend(echo_us.to_le_bytes());
        bytes.extend(held_us.to_le_bytes());
        bytes.extend(echo);
        for (seen, address) in addresses.iter().take(MOST_ADDRESSES) {
            bytes.push(u8::from(*seen));
            bytes.extend(address_bytes(*address));
        }
        let (head, body) = bytes.split_at_mut(HEAD);
        // A signal is shorter than what a cipher cannot seal.
        let tag = self.cipher.seal(nonce(self.counter), head, body).unwrap_or_default();
        bytes.extend(tag);
        bytes
    }
}

/// Opens what the other end, `side`, says under the shared key; the instance and the counter under which it says it.
pub(crate) fn open(key: &Key, side: u8, datagram: &[u8]) -> Option<(Instance, u64, Signal)> {
    let mut bytes = Bytes(datagram.get(1..).filter(|_| datagram.len() <= MOST)?);
    let (instance, counter) = (bytes.next()?, u64::from_le_bytes(bytes.next()?));
    let (sealed, tag) = bytes.0.split_last_chunk()?;
    let mut body = sealed.to_vec();
    let head = datagram.get(..HEAD)?;
    cipher(key, side, &instance).open(nonce(counter), head, &mut body, *tag).ok()?;
    let mut bytes = Bytes(&body);
    let [flags, generation] = bytes.next()?;
    let mut signal = Signal {
        hears: flags & HEARS != 0,
        direct: flags & DIRECT != 0,
        generation,
        count: u32::from_le_bytes(bytes.next()?),
        sent_us: u64::from_le_bytes(bytes.next()?),
        echo_us: u64::from_le_bytes(bytes.next()?),
        held_us: u32::from_le_bytes(bytes.next()?),
        echo: bytes.next()?,
        addresses: Vec::new(),
    };
    while let Some([seen]) = bytes.next() {
        signal.addresses.push((seen != 0, address_of(&bytes.next()?)));
    }
    Some((instance, counter, signal))
}

#[cfg(test)]
#[path = "../tests/inside/signal.rs"]
mod tests;
