//! Agreement: how an invite becomes a key, once. Both datagrams go by the relay, in the invite's room.
//!
//! ```text
//!     accepts                                  invites: y, Y = y·G; the link's secret is 16 bytes of BLAKE2s(Y)
//!     │ offer: X, tag under the secret ───────────►   │  one use, ten minutes
//!     │ ◄──── answer: Y masked, tag under the key     │
//!   key = BLAKE2s(secret; x·Y, X, Y)                 key
//! ```
//!
//! X and Y are fresh public keys of X25519 (RFC 7748). The link commits the inviter to Y before anybody has sent anything, so a thief
//! who has only read the link can take the place of the accepter, but never that of the inviter. The mask is made of the secret and X, so an
//! onlooker does not learn Y, from which the secret could be computed. A listener who records everything and finds the link later has
//! neither x nor y, and so not the key.
//!
//! The first offer under the right tag uses the invite up. The same offer is answered again, because answers get lost. Any other one is
//! refused. A datagram with a wrong tag does nothing: guessing 128 bits is hopeless, and a limit of tries would let anybody end an invite.
//!
//! **The code**: a thief who can replace the link by his own on its way can take both places, and then each end has another key. [`code`] turns the
//! key into six digits that two people compare aloud. Nobody can search for keys with equal digits: the accepter's X is fixed before
//! Y is known (the offer uses the invite up), and Y is fixed by the link before X is known. So a thief has one chance in a million for each pair of runs.

use std::time::{Duration, Instant};

use cohold_protocol::key::Key;
use subtle::ConstantTimeEq;
use x25519_dalek::x25519;

use crate::Error;
use crate::frame::{AGREEMENT, Bytes, Public, datagram, pair};
use crate::invite::Invite;

/// How long an invite lives that nobody has used.
pub const LIFE: Duration = Duration::from_secs(600);
/// Bytes of an offer, an answer and a refusal.
pub const LEN: usize = 50;

const OFFER: u8 = 1;
const ANSWER: u8 = 2;
const REFUSAL: u8 = 3;

type Tag = [u8; 16];

fn emit(kind: u8, public: &Public, tag: Tag) -> [u8; LEN] {
    datagram(&[&[AGREEMENT, kind], public, &tag])
}

fn parse(datagram: &[u8]) -> Option<(u8, Public, Tag)> {
    let mut bytes = Bytes(datagram);
    let [first, kind] = bytes.next()?;
    let said = (kind, bytes.next()?, bytes.next()?);
    (first == AGREEMENT && datagram.len() == LEN).then_some(said)
}

/// What authenticates a public key: of an offer and a refusal under the secret, of an answer under the key that was agreed on.
fn tag(key: &Key, kind: u8, public: &Public) -> Tag {
    key.derive("agreement").with(&[kind]).with(public).first()
}

fn is_tag(one: Tag, other: Tag) -> bool {
    one.ct_eq(&other).into()
}

/// The key that both come to; none where the other's public key leaves no choice.
fn agree(invite: &Key, own: &Key, theirs: &Public, [offered, answered]: [&Public; 2]) -> Option<Key> {
    let shared = x25519(*own.bytes(), *theirs);
    let agreed = invite.derive("agreed").with(&shared).with(offered).with(answered);
    (shared != [0; 32]).then(|| Key::new(agreed.first()))
}

/// Hides the inviter's public key from everybody without the link, and shows it again.
fn masked(invite: &Key, offered: &Public, public: &Public) -> Public {
    let mask: Public = invite.derive("mask").with(offered).first();
    std::array::from_fn(|at| public[at] ^ mask[at])
}

/// Six digits of a key that was agreed on. If two people read each other the same digits, they have one key and nobody is between them.
pub fn code(key: &Key) -> String {
    let number = u64::from_le_bytes(key.derive("code").first()) % 1_000_000;
    format!("{:03} {:03}", number / 1000, number % 1000)
}

/// What has become of an invite that waits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Heard {
    /// Nothing of it.
    Nothing,
    /// The other side is here, and this is the key.
    Agreed(Key),
    /// Somebody else has come with the link after it was used.
    Second,
}

/// The side that waits.
#[derive(Debug)]
pub struct Inviter {
    /// What to send to the other side, as a link.
    pub invite: Invite,
    secret: Key,
    public: Public,
    since: Instant,
    /// The offer that was taken, and its answer.
    taken: Option<(Public, [u8; LEN])>,
}

impl Inviter {
    /// Waits at this meeting place from now on; `entropy` must be unforeseeable.
    pub fn new(meet: &str, entropy: &Key, now: Instant) -> Self {
        let (secret, public) = pair(entropy);
        Self { invite: Invite::of(meet, &public), secret, public, since: now, taken: None }
    }

    /// Whether nobody has used it in time.
    pub fn is_over(&self, now: Instant) -> bool {
        self.taken.is_none() && now.saturating_duration_since(self.since) >= LIFE
    }

    /// Takes a datagram; what is to be answered, and what it means.
    pub fn hear(&mut self, now: Instant, datagram: &[u8]) -> (Option<[u8; LEN]>, Heard) {
        let invite = self.invite.key();
        let Some((OFFER, offered, said)) = parse(datagram).filter(|_| !self.is_over(now)) else {
            return (None, Heard::Nothing);
        };
        if !is_tag(tag(&invite, OFFER, &offered), said) {
            return (None, Heard::Nothing);
        }
        match &self.taken {
            Some((taken, answer)) if *taken == offered => (Some(*answer), Heard::Nothing),
            Some(_) => (Some(emit(REFUSAL, &offered, tag(&invite, REFUSAL, &offered))), Heard::Second),
            None => {
                let Some(key) = agree(&invite, &self.secret, &offered, [&offered, &self.public]) else {
                    return (None, Heard::Nothing);
                };
                let answer = emit(ANSWER, &masked(&invite, &offered, &self.public), tag(&key, ANSWER, &self.public));
                self.taken = Some((offered, answer));
                // It makes no other key.
                self.secret = Key::new([0; Key::LEN]);
                (Some(answer), Heard::Agreed(key))
            }
        }
    }
}

/// The side that has the link.
#[derive(Debug)]
pub struct Accepter {
    invite: Invite,
    secret: Key,
    public: Public,
}

impl Accepter {
    /// One that has not asked yet; `entropy` must be unforeseeable.
    pub fn new(invite: &Invite, entropy: &Key) -> Self {
        let (secret, public) = pair(entropy);
        Self { invite: invite.clone(), secret, public }
    }

    /// What to send until there is an answer.
    pub fn offer(&self) -> [u8; LEN] {
        emit(OFFER, &self.public, tag(&self.invite.key(), OFFER, &self.public))
    }

    /// The key, once the answer is here; none where it is no answer to this offer.
    ///
    /// # Errors
    /// The link has been used by somebody else.
    pub fn hear(&self, datagram: &[u8]) -> Result<Option<Key>, Error> {
        let invite = self.invite.key();
        match parse(datagram) {
            Some((ANSWER, hidden, said)) => {
                let answered = masked(&invite, &self.public, &hidden);
                let key = agree(&invite, &self.secret, &answered, [&self.public, &answered]);
                let key = key.filter(|_| self.invite.is_of(&answered));
                Ok(key.filter(|key| is_tag(tag(key, ANSWER, &answered), said)))
            }
            Some((REFUSAL, public, said)) if public == self.public && is_tag(tag(&invite, REFUSAL, &public), said) => {
                Err(Error::Used)
            }
            _ => Ok(None),
        }
    }
}
