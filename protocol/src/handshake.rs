//! Handshake: how two peers that share a key come to share a session, in any order, whoever restarts.
//!
//! A greeting carries a **challenge** of its sender's and echoes one of the receiver's. A challenge is good for 1 s from when it
//! was first offered; every 100 ms there is a new one, so that a round trip of up to 900 ms leads to a session. A link that takes older flow
//! ([`crate::link::Link::within`]) has challenges that are good for longer, ten at once in any case. An echo of one that
//! is good, under a right tag, proves that the sender holds the key and was there within that time, because nobody could have
//! known the challenge before; only that makes a session. Its keys come of the shared key and of the two ends' **ephemerals**,
//! which a greeting carries too: public keys of X25519 (RFC 7748), as in Noise's NNpsk0. Each end keeps its own until a session
//! made with it is confirmed or was not in time, then it wipes the secret: whoever gets hold of the shared key later reads nothing
//! of what was recorded. Both ends follow the same rules, so hellos that cross need no arbiter: a greeting of the ephemeral of the
//! session at hand is nothing new; another that echoes a good challenge makes a session; any other may be old, so that a hello is
//! answered with the newest challenge, a welcome is dropped, and neither is remembered.
//!
//! ```text
//!     A                                    B
//!     │ hello(E, a, –) ──────────────────► │  answers, keeps nothing
//!     │ ◄─────────────── welcome(F, b, a)  │
//!     │ session(E, F)                      │
//!     │ hello(E, a, b), sealed probe ────► │  session(E, F)
//!     │ ◄─────────────── sealed reply      │
//!     │ confirmed: E, a make no other      │
//!     │ sealed reply ────────────────────► │  confirmed: F, b make no other
//! ```
//!
//! **Invariants**: a greeting from the past or from a stranger changes nothing and is given no memory. An ephemeral that made a
//! confirmed session makes no other; nor does a challenge that was offered before that, or is older than 1 s. What a peer sent is
//! not accepted by itself: each direction has its key.
//!
//! **Cost**: two multiplications a session. One makes the next ephemeral when a session is confirmed or given up; the other only a
//! greeting under a right tag that echoes a good challenge brings about, and at most every 50 ms.
//!
//! **Limit**: old hellos make a peer answer, byte for byte as long. A peer whose randomness repeats itself at every start
//! gets fresh keys all the same from a peer that has heard it before; two such peers do not.

use heapless::Vec;
use x25519_dalek::{X25519_BASEPOINT_BYTES, x25519};

use crate::key::{Derivation, Key};
use crate::session::{Offer, Session};
use crate::wire::{self, Challenge, Ephemeral, Greeting, GreetingKind, PeerId};
use crate::{ends::Ends, error::Refusal, parameters::Parameters};

/// How long a challenge is good for at least, from when it was first offered, µs.
pub(crate) const LIFE_US: u64 = 1_000_000;
/// Challenges that can be good at once: each is offered for a tenth of its life.
const GOOD: usize = 10;

/// The shortest time between two multiplications that greetings bring about, µs.
const MULTIPLY_EVERY_US: u64 = 50_000;

/// The key under which the greetings of one end to the other are authentic.
fn greeting_key(pre_shared: &Key, from: PeerId, to: PeerId) -> Key {
    pre_shared.derive("greeting").with(&[from.0, to.0]).end()
}

/// Reads a greeting to this end on a line, if it is authentic under that key.
fn open(ends: Ends, line: u32, datagram: &[u8], inward: &Key) -> Result<Greeting, Refusal> {
    let (greeting, body, tag) = Greeting::parse(datagram)?;
    ends.check(greeting.from, greeting.to)?;
    if greeting.line != line {
        return Err(Refusal::OtherLine);
    }
    if inward.verifies(body, tag) { Ok(greeting) } else { Err(Refusal::ForgedGreeting) }
}

/// Whether a datagram is a greeting to this end on a line under the shared key: two hashes, and nothing that has to be made before.
pub(crate) fn is_called(pre_shared: &Key, ends: Ends, line: u32, datagram: &[u8]) -> Result<(), Refusal> {
    open(ends, line, datagram, &greeting_key(pre_shared, ends.remote, ends.local)).map(drop)
}

/// What a peer needs to greet and to judge greetings.
#[derive(Debug)]
#[cfg_attr(test, derive(Clone))]
pub(crate) struct Handshake {
    ends: Ends,
    line: u32,
    pre_shared: Key,
    outward: Key,
    inward: Key,
    entropy: Key,
    drawn: u64,
    /// What the next session is made from, and the secret of its ephemeral.
    local: Offer,
    secret: Key,
    /// The last ephemeral of the other end's, and what it makes with ours.
    agreed: Option<(Ephemeral, Key)>,
    next_multiplication_us: u64,
    /// How long a challenge is good for, µs.
    pub(crate) life_us: u64,
    /// Challenges and when each was first offered, µs, oldest first.
    offered: Vec<(Challenge, u64), GOOD>,
    parameters: Parameters,
}

impl Handshake {
    /// Greets under the shared key. `entropy` must differ at every start of the peer and be unforeseeable.
    pub(crate) fn new(pre_shared: Key, ends: Ends, parameters: Parameters, entropy: &Key) -> Self {
        let Ends { local, remote } = ends;
        let incarnation = u64::from_le_bytes(entropy.derive("incarnation").first());
        let mut handshake = Self {
            ends,
            line: 0,
            outward: greeting_key(&pre_shared, local, remote),
            inward: greeting_key(&pre_shared, remote, local),
            pre_shared,
            entropy: entropy.clone(),
            drawn: 0,
            local: Offer { ephemeral: Ephemeral::default(), incarnation },
            secret: Key::new([0; Key::LEN]),
            agreed: None,
            next_multiplication_us: 0,
            life_us: LIFE_US,
            offered: Vec::new(),
            parameters,
        };
        handshake.renew();
        handshake
    }

    pub(crate) fn set_line(&mut self, line: u32) {
        self.line = line;
    }

    fn draw(&mut self, label: &str) -> Derivation {
        self.drawn = self.drawn.wrapping_add(1);
        self.entropy.derive(label).with(&self.drawn.to_le_bytes())
    }

    /// What was offered so far has made a session, and makes no other.
    pub(crate) fn renew(&mut self) {
        self.forget();
        self.secret = self.draw("ephemeral").end();
        self.local.ephemeral = x25519(*self.secret.bytes(), X25519_BASEPOINT_BYTES);
        self.agreed = None;
    }

    /// What the other end's ephemeral makes with ours.
    fn agree(&mut self, now: u64, ephemeral: &Ephemeral) -> Result<Key, Refusal> {
        if let Some((_, agreed)) = self.agreed.as_ref().filter(|(theirs, _)| theirs == ephemeral) {
            return Ok(agreed.clone());
        }
        if now < self.next_multiplication_us {
            return Err(Refusal::Hurried);
        }
        self.next_multiplication_us = now.saturating_add(MULTIPLY_EVERY_US);
        let agreed = Key::new(x25519(*self.secret.bytes(), *ephemeral));
        if agreed.is_zero() {
            return Err(Refusal::WeakEphemeral);
        }
        self.agreed = Some((*ephemeral, agreed.clone()));
        Ok(agreed)
    }

    /// The challenge to offer now.
    fn offer(&mut self, now: u64) -> Challenge {
        if let Some((challenge, first_us)) = self.offered.last()
            && now.saturating_sub(*first_us) < self.life_us / GOOD as u64
        {
            return *challenge;
        }
        if self.offered.is_full() {
            self.offered.remove(0);
        }
        let challenge = self.draw("challenge").first();
        // There is room now.
        let _ = self.offered.push((challenge, now));
        challenge
    }

    /// No challenge that was offered so far is good for anything any more.
    pub(crate) fn forget(&mut self) {
        self.offered.clear();
    }

    /// Writes a greeting to the front of `out` and gives its length.
    pub(crate) fn greet(
        &mut self,
        now: u64,
        kind: GreetingKind,
        echo: Challenge,
        out: &mut [u8],
    ) -> Result<usize, wire::Error> {
        let challenge = self.offer(now);
        let (count, tables) = self.parameters.hashes();
        let Ends { local: from, remote: to } = self.ends;
        let Offer { ephemeral, incarnation } = self.local;
        let length = wire::Error::length("greeting", Greeting::TAGGED, out.len());
        let (body, rest) = out.split_at_mut_checked(Greeting::LEN).ok_or(length)?;
        let tag = rest.first_chunk_mut().ok_or(length)?;
        let line = self.line;
        Greeting { kind, from, to, line, challenge, echo, incarnation, ephemeral, count, tables }.emit(body)?;
        *tag = self.outward.tag(body);
        Ok(Greeting::TAGGED)
    }

    /// Reads a greeting if it is for this peer, from the other end and authentic.
    pub(crate) fn open(&self, datagram: &[u8]) -> Result<Greeting, Refusal> {
        open(self.ends, self.line, datagram, &self.inward)
    }

    /// Whether an authentic greeting echoes a challenge that is good at `now`.
    pub(crate) fn is_fresh(&self, now: u64, greeting: &Greeting) -> bool {
        let good = |first_us: u64| now.saturating_sub(first_us) < self.life_us;
        self.offered.iter().any(|(challenge, first_us)| *challenge == greeting.echo && good(*first_us))
    }

    /// The session that a fresh greeting leads to, unless the two peers have different parameters.
    pub(crate) fn accept(&mut self, now: u64, greeting: &Greeting) -> Result<Session, Refusal> {
        if let Some(table) = self.parameters.difference(greeting.count, &greeting.tables) {
            return Err(Refusal::Parameters(table));
        }
        let remote = Offer { ephemeral: greeting.ephemeral, incarnation: greeting.incarnation };
        let agreed = self.agree(now, &greeting.ephemeral)?;
        Ok(Session::new(&self.pre_shared, self.ends, [self.local, remote], &agreed, &self.parameters.hashes(), now))
    }
}

#[cfg(test)]
#[path = "../tests/inside/handshake.rs"]
mod tests;
