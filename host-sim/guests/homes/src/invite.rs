//! An invite: where to meet, and a secret that serves once; as a link that is read out, typed or scanned.
//!
//! `haptic://HOST:PORT/` and 29 letters and digits: 128 bits of secret, and 16 by which a mistyped link is known before anything is sent. The
//! secret is a hash of the inviter's public key ([`crate::agreement`]). From it come the room and the two seats at the meeting place, and the key that
//! authenticates the agreement. The secret itself is never sent. A link that is found after its use is good for nothing: the key was agreed on by
//! X25519, and the session has another room, made of that key.

use std::fmt;

use cohold_protocol::key::Key;
use zeroize::Zeroize;

use crate::Error;
use crate::frame::Public;
use crate::seat::Seat;

const SCHEME: &str = "haptic://";
const LETTERS: &[u8; 32] = b"abcdefghijklmnopqrstuvwxyz234567";
/// Bytes of the secret.
const SECRET: usize = 16;
/// Bytes by which a mistake is found.
const CHECK: usize = 2;

/// An invite.
#[derive(Clone)]
pub struct Invite {
    /// Host and port of the meeting place.
    pub meet: String,
    secret: [u8; SECRET],
}

impl fmt::Debug for Invite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Invite({}, …)", self.meet)
    }
}

impl Drop for Invite {
    fn drop(&mut self) {
        self.secret.zeroize();
    }
}

impl Invite {
    /// The invite of the end that has this public key.
    pub fn of(meet: &str, public: &Public) -> Self {
        Self { meet: meet.to_owned(), secret: Key::new(*public).derive("invite").first() }
    }

    /// Whether the end that has this public key made it.
    pub(crate) fn is_of(&self, public: &Public) -> bool {
        self.key() == Self::of(&self.meet, public).key()
    }

    /// The key that everything of this invite is made from.
    pub(crate) fn key(&self) -> Key {
        let mut key = [0; Key::LEN];
        key[..SECRET].copy_from_slice(&self.secret);
        Key::new(key)
    }

    /// A seat in its room, side 0 for who invites; `entropy` must be unforeseeable.
    pub fn seat(&self, side: u8, entropy: &Key) -> Seat {
        Seat::new(&self.key(), side, entropy)
    }

    fn check(&self) -> [u8; CHECK] {
        self.key().derive("link").with(self.meet.as_bytes()).first()
    }

    /// As a link.
    pub fn link(&self) -> String {
        let bytes = [&self.secret[..], &self.check()].concat();
        let bit = |at: usize| bytes.get(at / 8).map_or(0, |byte| byte >> (7 - at % 8) & 1);
        let letter = |at: usize| LETTERS[usize::from((0..5).fold(0, |all, more| all << 1 | bit(5 * at + more)))];
        let letters: String = (0..(8 * bytes.len()).div_ceil(5)).map(|at| char::from(letter(at))).collect();
        format!("{SCHEME}{}/{letters}", self.meet)
    }

    /// From a link.
    ///
    /// # Errors
    /// It is none, or a letter of it is wrong.
    pub fn parse(link: &str) -> Result<Self, Error> {
        let (meet, letters) =
            link.trim().strip_prefix(SCHEME).and_then(|rest| rest.split_once('/')).ok_or(Error::NoLink)?;
        let has_port =
            meet.rsplit_once(':').is_some_and(|(host, port)| !host.is_empty() && port.parse::<u16>().is_ok());
        if !has_port || letters.len() != (8 * (SECRET + CHECK)).div_ceil(5) {
            return Err(Error::NoLink);
        }
        let mut bytes = [0; SECRET + CHECK];
        for (at, letter) in letters.to_ascii_lowercase().bytes().enumerate() {
            let value = LETTERS.iter().position(|known| *known == letter).ok_or(Error::Mistyped)?;
            for more in (0..5).filter(|more| value >> (4 - more) & 1 == 1) {
                // The last letter has a bit that stands for nothing, and is 0.
                *bytes.get_mut((5 * at + more) / 8).ok_or(Error::Mistyped)? |= 0x80 >> ((5 * at + more) % 8);
            }
        }
        let (secret, check) = bytes.split_first_chunk().ok_or(Error::NoLink)?;
        let invite = Self { meet: meet.to_owned(), secret: *secret };
        if invite.check() == check { Ok(invite) } else { Err(Error::Mistyped) }
    }
}
