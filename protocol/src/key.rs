//! Keys: the one both peers hold, the operator's, and every other one derived from them.
//!
//! One primitive does it all: BLAKE2s (RFC 7693) with a key is a pseudo-random function, so `derive` gives keys that say
//! nothing about each other, and `tag` authenticates what is not sealed. A label of 16 bytes keeps the uses apart.
//!
//! **Invariants**: a key is never printed, wiped from memory when dropped, and compared in a time that does not tell where two
//! differ. **Limit**: what was moved or stood on the stack meanwhile is not wiped; whoever reads the memory of a running peer has
//! its shared key anyway.

use core::fmt;

use blake2::digest::{FixedOutput, KeyInit, Mac, Update};
use blake2::{Blake2sMac, Blake2sMac256, digest::array::Array, digest::consts::U16};
use subtle::ConstantTimeEq;
use zeroize::Zeroize;

/// Bytes of the authentication tag that ends every datagram.
pub const TAG_LEN: usize = 16;
/// Bytes of the number that a key seals with once and never again.
pub const NONCE_LEN: usize = 12;
/// What a datagram is sealed with once and never again.
pub type Nonce = [u8; NONCE_LEN];
/// What shows that a sealed body and what stands before it are whole.
pub type Tag = [u8; TAG_LEN];

/// What a key is for. A board has one of each, drawn by itself: who holds one has nothing of the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Links between peers, or of one line to a hub or server.
    Peers,
    /// The operator's link to a board.
    Operator,
}

impl Role {
    /// What an image of such a key begins with.
    fn mark(self) -> &'static [u8; 8] {
        match self {
            Self::Peers => b"haptpeer",
            Self::Operator => b"haptoper",
        }
    }
}

/// A secret key of 32 bytes.
#[derive(Clone)]
pub struct Key([u8; Self::LEN]);

impl PartialEq for Key {
    fn eq(&self, other: &Self) -> bool {
        self.0.ct_eq(&other.0).into()
    }
}

impl Eq for Key {}

impl Drop for Key {
    fn drop(&mut self) {
        self.0.zeroize();
    }
}

impl Key {
    /// Length of a key, bytes.
    pub const LEN: usize = 32;

    /// A key from its bytes, which must come from a good source of randomness and stay secret.
    pub fn new(bytes: [u8; Self::LEN]) -> Self {
        Self(bytes)
    }

    /// The largest number of a line.
    pub const MOST_LINES: u32 = 4096;

    /// The key of line `number` of a server whose own key is this one: one key for each client, so that a client that is
    /// opened gives up its own line and no other. Line 0 has the key itself.
    pub fn line(&self, number: u32) -> Self {
        if number == 0 { self.clone() } else { self.derive("line").with(&number.to_le_bytes()).end() }
    }

    /// Length of [`Key::image`], bytes.
    pub const IMAGE: usize = 64;

    /// The key as a microcontroller keeps it in flash: `haptpeer` or `haptoper`, by its role, 8 zeros, a tag by which the key
    /// vouches for itself in that role, the key. Flash that was never written, or not wholly, is no image.
    pub fn image(&self, role: Role) -> [u8; Self::IMAGE] {
        let mut image = [0; Self::IMAGE];
        let tag = self.tag(role.mark());
        let parts = [&role.mark()[..], &[0; 8], &tag, &self.0].into_iter().flatten();
        image.iter_mut().zip(parts).for_each(|(to, from)| *to = *from);
        image
    }

    /// The key of an image, if it is for this role.
    pub fn from_image(image: &[u8; Self::IMAGE], role: Role) -> Option<Self> {
        let key = Self(*image.last_chunk()?);
        (!key.is_zero() && key.image(role) == *image).then_some(key)
    }

    /// The bytes, for the cipher, or for the key file of one line.
    pub fn bytes(&self) -> &[u8; Self::LEN] {
        &self.0
    }

    /// Random bytes from several sources, for [`crate::link::Config::entropy`]: other ones as soon as one of the parts differs, and
    /// unforeseeable as long as one of them, or the key, is.
    pub fn hedged(&self, parts: &[&[u8]]) -> [u8; Self::LEN] {
        let mut derivation = self.derive("hedge");
        for part in parts {
            let len = u32::try_from(part.len()).unwrap_or(u32::MAX);
            derivation = derivation.with(&len.to_le_bytes()).with(part);
        }
        *derivation.end().bytes()
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.0 == [0; Self::LEN]
    }

    /// A function of this key that takes in data piece by piece and ends as another key, or as a checksum. Of a label, the first 16
    /// bytes count.
    pub fn derive(&self, label: &str) -> Derivation {
        let mut padded = [0; 16];
        padded.iter_mut().zip(label.bytes()).for_each(|(to, from)| *to = from);
        let mut mac = Blake2sMac256::new(&Array(self.0));
        Update::update(&mut mac, &padded);
        Derivation(mac)
    }

    pub(crate) fn tag(&self, bytes: &[u8]) -> Tag {
        Blake2sMac::<U16>::new(&Array(self.0)).chain_update(bytes).finalize_fixed().0
    }

    /// Whether `tag` is the tag of `bytes` under this key, in a time that does not tell where it differs.
    pub(crate) fn verifies(&self, bytes: &[u8], tag: &Tag) -> bool {
        Blake2sMac::<U16>::new(&Array(self.0)).chain_update(bytes).verify(&Array(*tag)).is_ok()
    }
}

impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Key(…)")
    }
}

/// A key on its way to becoming another one.
#[derive(Clone)]
pub struct Derivation(Blake2sMac256);

impl Derivation {
    /// Takes in the next piece of data.
    pub fn with(mut self, data: &[u8]) -> Self {
        Update::update(&mut self.0, data);
        self
    }

    pub(crate) fn end(self) -> Key {
        Key(self.0.finalize_fixed().0)
    }

    /// The first `N` of its bytes, for what is not secret.
    pub fn first<const N: usize>(self) -> [u8; N] {
        self.end().0.first_chunk().copied().unwrap_or([0; N])
    }
}
