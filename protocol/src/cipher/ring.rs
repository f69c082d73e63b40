//! The cipher from ring, for PCs.
//!
//! ring does not wipe the keys that it is given: when a cipher is dropped, a key of zeros is put in the place of its own, which
//! is on the heap and never moved. What stood on the stack meanwhile is not wiped, as with every key.

extern crate alloc;

use alloc::boxed::Box;
use core::hint::black_box;

use ring::aead::{self, Aad, CHACHA20_POLY1305, LessSafeKey, UnboundKey};

use crate::error::Refusal;
use crate::key::{Key, Nonce, Tag};

/// ChaCha20-Poly1305 under one key, wiped when dropped. Always with one: ring refuses none of this length.
#[cfg_attr(test, derive(Clone))]
pub struct Cipher(Option<Box<LessSafeKey>>);

impl Drop for Cipher {
    fn drop(&mut self) {
        if let (Some(kept), Some(zeros)) = (&mut self.0, Self::held(&[0; Key::LEN])) {
            **kept = zeros;
            // As if somebody looked at it, so that it is written.
            black_box(kept);
        }
    }
}

impl Cipher {
    /// A cipher with this key.
    pub fn new(key: &Key) -> Self {
        Self(Self::held(key.bytes()).map(Box::new))
    }

    fn held(key: &[u8; Key::LEN]) -> Option<LessSafeKey> {
        UnboundKey::new(&CHACHA20_POLY1305, key).ok().map(LessSafeKey::new)
    }

    /// Encrypts `body` in place and gives the tag of it and of `aad`, the data that stand in the open. A nonce serves one body and no other.
    ///
    /// # Errors
    /// A body of 256 GB or more.
    pub fn seal(&self, nonce: Nonce, aad: &[u8], body: &mut [u8]) -> Result<Tag, Refusal> {
        let (nonce, key) = (aead::Nonce::assume_unique_for_key(nonce), self.0.as_ref().ok_or(Refusal::Forged)?);
        let tag = key.seal_in_place_separate_tag(nonce, Aad::from(aad), body);
        tag.ok().and_then(|tag| tag.as_ref().try_into().ok()).ok_or(Refusal::Forged)
    }

    /// Decrypts `body` if `tag` is of it and of `aad`; else the error is [`Refusal::Forged`].
    pub fn open(&self, nonce: Nonce, aad: &[u8], body: &mut [u8], tag: Tag) -> Result<(), Refusal> {
        let (nonce, key) = (aead::Nonce::assume_unique_for_key(nonce), self.0.as_ref().ok_or(Refusal::Forged)?);
        let opened = key.open_in_place_separate_tag(nonce, Aad::from(aad), tag.into(), body, 0..);
        opened.map(|_| ()).map_err(|_| Refusal::Forged)
    }
}
