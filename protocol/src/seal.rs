//! Sealing: one direction of one session, ChaCha20-Poly1305 (RFC 8439).
//!
//! Each direction has its own keys, so that what a peer sent is never opened by itself. The sequence number is the nonce
//! and also picks the key: every 2²⁰ datagrams (2.3 h at one each 8 ms) both ends move on to the next traffic key without
//! a word about it. The header is authenticated, the message encrypted, both or neither.
//!
//! **Invariants**: [`Counter`] hands out a number once and lives as long as its peer, across sessions, so that no key
//! meets a nonce twice; a datagram whose tag is wrong leaves no trace. There is no way to send a message unsealed.

use chacha20poly1305::aead::{AeadInOut, KeyInit};
use chacha20poly1305::{ChaCha20Poly1305, aead::array::Array};

use crate::wire::{self, Header, Message, PeerId, TAG_LEN};
use crate::{error::Refusal, key::Key, replay::SEQUENCE_LIMIT};

/// How many sequence numbers share a traffic key, as a power of 2.
pub(crate) const EPOCH_BITS: u32 = 20;

#[derive(Debug, Default)]
pub(crate) struct Counter {
    next: u64,
}

impl Counter {
    /// Starts at `next` instead of 0, to try what happens late in a peer's life.
    #[cfg(test)]
    pub(crate) fn starting_at(next: u64) -> Self {
        Self { next }
    }

    pub(crate) fn draw(&mut self) -> Result<u64, Refusal> {
        if self.next >= SEQUENCE_LIMIT {
            return Err(Refusal::Exhausted);
        }
        let drawn = self.next;
        self.next += 1;
        Ok(drawn)
    }
}

pub(crate) struct Direction {
    base: Key,
    epoch: u64,
    cipher: ChaCha20Poly1305,
}

impl Direction {
    /// The direction from one peer to another, under a session's secret.
    pub(crate) fn new(session_secret: &Key, from: PeerId, to: PeerId) -> Self {
        let base = session_secret.derive("direction").with(&[from.0, to.0]).end();
        let cipher = Self::traffic(&base, 0);
        Self { base, epoch: 0, cipher }
    }

    fn traffic(base: &Key, epoch: u64) -> ChaCha20Poly1305 {
        let key = base.derive("epoch").with(&epoch.to_le_bytes()).end();
        ChaCha20Poly1305::new(&Array(*key.bytes()))
    }

    fn nonce(sequence: u64) -> [u8; 12] {
        let mut nonce = [0; 12];
        if let Some(low) = nonce.last_chunk_mut() {
            *low = sequence.to_le_bytes();
        }
        nonce
    }

    /// Writes header, sealed message and tag to the front of `out` and gives their length.
    ///
    /// The header's sequence must be fresh from the sender's one [`Counter`].
    pub(crate) fn seal(&mut self, header: &Header, message: &Message, out: &mut [u8]) -> Result<usize, Refusal> {
        let epoch = header.sequence >> EPOCH_BITS;
        if epoch != self.epoch {
            self.cipher = Self::traffic(&self.base, epoch);
            self.epoch = epoch;
        }
        let too_short = wire::Error::Length { message: "datagram", wanted: Header::LEN + TAG_LEN, got: out.len() };
        let (head, rest) = out.split_first_chunk_mut::<{ Header::LEN }>().ok_or(too_short)?;
        header.emit(head)?;
        let len = message.emit(rest)?;
        let (body, rest) = rest.split_at_mut_checked(len).ok_or(too_short)?;
        let end = rest.first_chunk_mut::<TAG_LEN>().ok_or(too_short)?;
        let nonce = Array(Self::nonce(header.sequence));
        let tag = self.cipher.encrypt_inout_detached(&nonce, head, body.into()).map_err(|_| Refusal::Forged)?;
        *end = tag.0;
        Ok(Header::LEN + len + TAG_LEN)
    }

    /// Opens what [`Header::parse`] took apart, in place; the message as bytes.
    pub(crate) fn open<'a>(
        &mut self,
        header: &Header,
        head: &[u8; Header::LEN],
        sealed: &'a mut [u8],
    ) -> Result<&'a [u8], Refusal> {
        let length = wire::Error::Length { message: "sealed", wanted: TAG_LEN, got: sealed.len() };
        let (body, tag) = sealed.split_last_chunk_mut::<TAG_LEN>().ok_or(length)?;
        let (nonce, tag) = (Array(Self::nonce(header.sequence)), Array(*tag));
        let epoch = header.sequence >> EPOCH_BITS;
        if epoch == self.epoch {
            self.cipher.decrypt_inout_detached(&nonce, head, (&mut *body).into(), &tag).map_err(|_| Refusal::Forged)?;
        } else {
            let cipher = Self::traffic(&self.base, epoch);
            cipher.decrypt_inout_detached(&nonce, head, (&mut *body).into(), &tag).map_err(|_| Refusal::Forged)?;
            // Only the owner of the key gets here, so only it can move the epoch.
            if epoch > self.epoch {
                self.cipher = cipher;
                self.epoch = epoch;
            }
        }
        Ok(body)
    }
}
