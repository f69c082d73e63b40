//! Agreement: how an invite becomes a key, once. Both datagrams go by the relay, in the invite's room.
//!
//! ```text
//!   accepts                                         invites
//!     │ offer: X, tag under the secret ───────────►   │  one use, ten minutes, three wrong tries
//!     │ ◄──────────── answer: Y, tag under the key    │
//!   key = BLAKE2s(secret; x·Y, X, Y)                 key
//! ```
//!
//! X and Y are fresh public keys of X25519 (RFC 7748), as in Noise's NNpsk0. Who reads everything and finds the link later has neither x nor y, and so not the key;
//! who stands between has to know the secret before it is used, and then the true partner is refused and both are told. The first offer
//! under the right tag uses the invite up: the same offer is answered again, for answers get lost, any other is refused. A wrong tag is a
//! try; after three the invite is dead and nothing is answered. The secret has 128 bits, so that guesses are hopeless anyway, and a
//! password-authenticated exchange would add nothing.

use std::time::{Duration, Instant};

use haptic_protocol::key::Key;
use subtle::ConstantTimeEq;
use x25519_dalek::{X25519_BASEPOINT_BYTES, x25519};

use crate::Error;
use crate::frame::{AGREEMENT, Bytes};
use crate::invite::Invite;

/// How long an invite lives that nobody has used.
pub const LIFE: Duration = Duration::from_secs(600);
/// Wrong tries after which it is dead.
pub const TRIES: u8 = 3;
/// Bytes of an offer, an answer and a refusal.
pub const LEN: usize = 50;

const OFFER: u8 = 1;
const ANSWER: u8 = 2;
const REFUSAL: u8 = 3;

type Public = [u8; 32];
type Tag = [u8; 16];

fn emit(kind: u8, public: &Public, tag: Tag) -> [u8; LEN] {
    let mut bytes = [0; LEN];
    let parts = [&[AGREEMENT, kind][..], public, &tag].concat();
    bytes.iter_mut().zip(parts).for_each(|(to, from)| *to = from);
    bytes
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

/// A fresh secret key and its public key.
fn ephemeral(entropy: &Key) -> (Key, Public) {
    let secret = Key::new(entropy.derive("ephemeral").first());
    let public = x25519(*secret.bytes(), X25519_BASEPOINT_BYTES);
    (secret, public)
}

/// The key that both come to; none where the other's public key leaves no choice.
fn agree(invite: &Key, own: &Key, theirs: &Public, [offered, answered]: [&Public; 2]) -> Option<Key> {
    let shared = x25519(*own.bytes(), *theirs);
    let agreed = invite.derive("agreed").with(&shared).with(offered).with(answered);
    (shared != [0; 32]).then(|| Key::new(agreed.first()))
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
    /// A wrong try, the so-manieth.
    Wrong(u8),
}

/// The side that waits.
#[derive(Debug)]
pub struct Inviter {
    invite: Key,
    secret: Key,
    public: Public,
    since: Instant,
    wrong: u8,
    /// The offer that was taken, and its answer.
    taken: Option<(Public, [u8; LEN])>,
}

impl Inviter {
    /// Waits from now on; `entropy` must be unforeseeable.
    pub fn new(invite: &Invite, entropy: &Key, now: Instant) -> Self {
        let (secret, public) = ephemeral(entropy);
        Self { invite: invite.key(), secret, public, since: now, wrong: 0, taken: None }
    }

    /// Why it waits for nobody any more.
    pub fn over(&self, now: Instant) -> Option<Error> {
        let late = self.taken.is_none() && now.saturating_duration_since(self.since) >= LIFE;
        let guessed = self.taken.is_none() && self.wrong >= TRIES;
        guessed.then_some(Error::Guessed).or(late.then_some(Error::Over))
    }

    /// Takes a datagram; what is to be answered, and what it means.
    pub fn hear(&mut self, now: Instant, datagram: &[u8]) -> (Option<[u8; LEN]>, Heard) {
        let Some((OFFER, offered, said)) = parse(datagram).filter(|_| self.over(now).is_none()) else {
            return (None, Heard::Nothing);
        };
        if !is_tag(tag(&self.invite, OFFER, &offered), said) {
            self.wrong = self.wrong.saturating_add(1);
            return (None, Heard::Wrong(self.wrong));
        }
        match &self.taken {
            Some((taken, answer)) if *taken == offered => (Some(*answer), Heard::Nothing),
            Some(_) => (Some(emit(REFUSAL, &offered, tag(&self.invite, REFUSAL, &offered))), Heard::Second),
            None => {
                let Some(key) = agree(&self.invite, &self.secret, &offered, [&offered, &self.public]) else {
                    return (None, Heard::Nothing);
                };
                let answer = emit(ANSWER, &self.public, tag(&key, ANSWER, &self.public));
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
    invite: Key,
    secret: Key,
    public: Public,
}

impl Accepter {
    /// One that has not asked yet; `entropy` must be unforeseeable.
    pub fn new(invite: &Invite, entropy: &Key) -> Self {
        let (secret, public) = ephemeral(entropy);
        Self { invite: invite.key(), secret, public }
    }

    /// What to send until there is an answer.
    pub fn offer(&self) -> [u8; LEN] {
        emit(OFFER, &self.public, tag(&self.invite, OFFER, &self.public))
    }

    /// The key, once the answer is here; none where it is no answer to this offer.
    ///
    /// # Errors
    /// The link has been used by somebody else.
    pub fn hear(&self, datagram: &[u8]) -> Result<Option<Key>, Error> {
        match parse(datagram) {
            Some((ANSWER, answered, said)) => {
                let key = agree(&self.invite, &self.secret, &answered, [&self.public, &answered]);
                Ok(key.filter(|key| is_tag(tag(key, ANSWER, &answered), said)))
            }
            Some((REFUSAL, public, said))
                if public == self.public && is_tag(tag(&self.invite, REFUSAL, &public), said) =>
            {
                Err(Error::Used)
            }
            _ => Ok(None),
        }
    }
}
