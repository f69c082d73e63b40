//! Keys: the two that a board was given, the peers' (or its line's to a hub) and the operator's.
//!
//! `cargo xtask provision` puts their images ([`Key::image`]) side by side at the beginning of a sector of flash. A board takes both
//! or neither, and never one key for both roles: who holds the peers' key (the other peer, the owner of a hub) must not be able to
//! arm its motors. So one that was given a single key, by a version before, has none.

use cohold_protocol::key::{Key, Role};

use crate::store::Word;

/// Words of one key's image.
const IMAGE: u32 = (Key::IMAGE / size_of::<Word>()) as u32;
/// Words of both, from the beginning of the sector on.
pub const WORDS: u32 = 2 * IMAGE;
/// What the image of the single key of before began with.
const SINGLE: &[u8] = b"haptkey1";

/// The two keys of a board.
#[derive(Debug)]
pub struct Keys {
    /// Key of the link to the other peer, or to a hub.
    pub peers: Key,
    /// Key of the operator's port.
    pub operator: Key,
}

/// Why a board has no keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keyless {
    /// It was never given the peers', or not wholly.
    NoPeers,
    /// It was never given the operator's, or not wholly.
    NoOperator,
    /// It was given one key for both.
    Single,
    /// Both are the same.
    Same,
}

impl Keys {
    /// The keys in a sector whose words `read` gives.
    ///
    /// # Errors
    /// The sector holds no valid key.
    pub fn read(read: impl Fn(u32) -> Option<Word>) -> Result<Self, Keyless> {
        let key = |first, role| Key::from_image(&image(&read, first)?, role);
        let Some(peers) = key(0, Role::Peers) else {
            let single = read(0).is_some_and(|word| word.starts_with(SINGLE));
            return Err(if single { Keyless::Single } else { Keyless::NoPeers });
        };
        let operator = key(IMAGE, Role::Operator).ok_or(Keyless::NoOperator)?;
        if peers == operator { Err(Keyless::Same) } else { Ok(Self { peers, operator }) }
    }

    /// What the board's random bytes are mixed with ([`crate::hedge`]): another secret as soon as either key is another, so that
    /// neither meets again what it met before the other was changed, and one that nobody knows who holds but one of them.
    pub fn seed(&self) -> Key {
        Key::new(self.operator.hedged(&[self.peers.bytes()]))
    }
}

/// The image that begins at a word.
fn image(read: impl Fn(u32) -> Option<Word>, first: u32) -> Option<[u8; Key::IMAGE]> {
    let mut image = [0; Key::IMAGE];
    for (at, bytes) in (first..).zip(image.chunks_exact_mut(size_of::<Word>())) {
        bytes.copy_from_slice(&read(at)?);
    }
    Some(image)
}
