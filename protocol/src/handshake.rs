//! Handshake: how two peers that share a key come to share a session, in any order, whoever restarts.
//!
//! Every peer has one current **challenge**. A greeting carries its sender's challenge and echoes the receiver's. An echo
//! of the current challenge under a right tag proves that the sender holds the key and is there now, because nobody could
//! have known the challenge before; only that makes a session. Both ends follow the same three rules, the first
//! that applies, so hellos that cross need no arbiter: a greeting whose two challenges are those of the session at hand is nothing
//! new; one that echoes the current challenge makes a session; any other may be old, so that a hello is answered with the current
//! challenge, a welcome is dropped, and neither is remembered.
//!
//! ```text
//!     A                                    B
//!     │ hello(a, –) ─────────────────────► │  b is current: answers, keeps nothing
//!     │ ◄───────────────── welcome(b, a)   │
//!     │ session(a, b)                      │
//!     │ hello(a, b), sealed probe ───────► │  session(a, b)
//!     │ ◄───────────────── sealed probe    │  confirmed: draws b′
//!     │ confirmed: draws a′                │
//! ```
//!
//! **Invariants**: a greeting from the past or from a stranger changes nothing and is given no memory. A challenge that
//! made a confirmed session is never offered again. What a peer sent is not accepted by itself: each direction has its key.
//! **Limit**: old hellos make a peer answer, byte for byte as long. A peer whose randomness repeats itself at every start
//! gets fresh keys all the same from a peer that has heard it before; two such peers do not.

use crate::session::{Offer, Session};
use crate::wire::{self, Challenge, Greeting, GreetingKind};
use crate::{ends::Ends, error::Refusal, key::Key, parameters::Parameters};

/// What a peer needs to greet and to judge greetings.
#[derive(Debug)]
pub(crate) struct Handshake {
    ends: Ends,
    line: u32,
    shared: Key,
    outward: Key,
    inward: Key,
    entropy: Key,
    drawn: u64,
    offer: Offer,
    parameters: Parameters,
}

impl Handshake {
    /// Greets under the shared key. `entropy` must differ at every start of the peer and be unforeseeable.
    pub(crate) fn new(shared: Key, ends: Ends, parameters: Parameters, entropy: &Key) -> Self {
        let Ends { local, remote } = ends;
        let greeting_key = |from: wire::PeerId, to: wire::PeerId| shared.derive("greeting").with(&[from.0, to.0]).end();
        let incarnation = u64::from_le_bytes(entropy.derive("incarnation").first());
        let mut handshake = Self {
            ends,
            line: 0,
            outward: greeting_key(local, remote),
            inward: greeting_key(remote, local),
            shared,
            entropy: entropy.clone(),
            drawn: 0,
            offer: Offer { challenge: [0; 16], incarnation },
            parameters,
        };
        handshake.renew();
        handshake
    }

    pub(crate) fn set_line(&mut self, line: u32) {
        self.line = line;
    }

    pub(crate) fn renew(&mut self) {
        self.drawn = self.drawn.wrapping_add(1);
        self.offer.challenge = self.entropy.derive("challenge").with(&self.drawn.to_le_bytes()).first();
    }

    /// Writes a greeting with the current challenge to the front of `out` and gives its length.
    pub(crate) fn greet(&self, kind: GreetingKind, echo: Challenge, out: &mut [u8]) -> Result<usize, wire::Error> {
        let (count, tables) = self.parameters.hashes();
        let Ends { local: from, remote: to } = self.ends;
        let Offer { challenge, incarnation } = self.offer;
        let length = wire::Error::Length { message: "greeting", wanted: Greeting::TAGGED, got: out.len() };
        let (body, rest) = out.split_at_mut_checked(Greeting::LEN).ok_or(length)?;
        let tag = rest.first_chunk_mut().ok_or(length)?;
        Greeting { kind, from, to, line: self.line, challenge, echo, incarnation, count, tables }.emit(body)?;
        *tag = self.outward.tag(body);
        Ok(Greeting::TAGGED)
    }

    /// Reads a greeting if it is for this peer, from the other end and authentic.
    pub(crate) fn open(&self, datagram: &[u8]) -> Result<Greeting, Refusal> {
        let (greeting, body, tag) = Greeting::parse(datagram)?;
        self.ends.check(greeting.from, greeting.to)?;
        if greeting.line != self.line {
            return Err(Refusal::OtherLine);
        }
        if self.inward.verifies(body, tag) { Ok(greeting) } else { Err(Refusal::ForgedGreeting) }
    }

    /// Whether an authentic greeting echoes the current challenge.
    pub(crate) fn is_fresh(&self, greeting: &Greeting) -> bool {
        greeting.echo == self.offer.challenge
    }

    /// The session that a fresh greeting leads to, unless the two peers were told different things.
    pub(crate) fn accept(&self, greeting: &Greeting) -> Result<Session, Refusal> {
        if let Some(table) = self.parameters.difference(greeting.count, &greeting.tables) {
            return Err(Refusal::Parameters(table));
        }
        let remote = Offer { challenge: greeting.challenge, incarnation: greeting.incarnation };
        Ok(Session::new(&self.shared, self.ends, self.offer, remote, &self.parameters.hashes()))
    }
}
