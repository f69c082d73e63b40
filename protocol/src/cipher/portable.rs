//! The cipher in Rust alone, from RustCrypto.

use chacha20poly1305::aead::{AeadInOut, KeyInit};
use chacha20poly1305::{ChaCha20Poly1305, aead::array::Array};

use crate::error::Refusal;
use crate::key::{Key, Nonce, Tag};

/// ChaCha20-Poly1305 under one key, wiped when dropped.
#[cfg_attr(test, derive(Clone))]
pub struct Cipher(ChaCha20Poly1305);

impl Cipher {
    /// A cipher with this key.
    pub fn new(key: &Key) -> Self {
        Self(ChaCha20Poly1305::new(&Array(*key.bytes())))
    }

    /// Encrypts `body` in place and gives the tag of it and of `aad`, the data that stand in the open. A nonce serves one body and no other.
    ///
    /// # Errors
    /// A body of 256 GB or more.
    pub fn seal(&self, nonce: Nonce, aad: &[u8], body: &mut [u8]) -> Result<Tag, Refusal> {
        let tag = self.0.encrypt_inout_detached(&Array(nonce), aad, body.into());
        tag.map(|tag| tag.0).map_err(|_| Refusal::Forged)
    }

    /// Decrypts `body` if `tag` is of it and of `aad`; else the error is [`Refusal::Forged`].
    pub fn open(&self, nonce: Nonce, aad: &[u8], body: &mut [u8], tag: Tag) -> Result<(), Refusal> {
        self.0.decrypt_inout_detached(&Array(nonce), aad, body.into(), &Array(tag)).map_err(|_| Refusal::Forged)
    }
}
