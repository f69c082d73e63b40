//! A seat at the meeting place: how an end takes one, keeps it, and takes it again after the place has started anew or its own address has changed.
//!
//! A join every half second keeps seat and mapping; where the seat is not there, or nothing comes by the relay that should, one every 50 ms.
//! The meeting place keeps nothing of who has not sent its cookie back, and gives the seat only to who has its secret key: an onlooker of a join has neither.

use std::collections::VecDeque;
use std::net::SocketAddr;
use std::time::{Duration, Instant};

use cohold_protocol::key::Key;

use crate::frame::{Join, Welcome, name, pair, proof};

/// Between two joins of who is seated.
const KEEP: Duration = Duration::from_millis(500);
/// Between two joins of who is not.
const HURRY: Duration = Duration::from_millis(50);
/// Joins whose welcome may be under way: a round trip of 800 ms.
const UNDER_WAY: usize = 16;
/// No welcome for so long: the meeting place is not there, or does not know this end any more.
const GONE: Duration = Duration::from_millis(1600);

/// A seat.
#[derive(Clone, Debug)]
pub struct Seat {
    join: Join,
    secret: Key,
    /// Nonces of the newest joins.
    nonces: VecDeque<[u8; 8]>,
    entropy: Key,
    drawn: u64,
    sent: Option<Instant>,
    welcomed: Option<Instant>,
    seated: bool,
    other: bool,
    /// Where this end is seen from the meeting place.
    pub seen: Option<SocketAddr>,
    /// The meeting place has said no.
    pub refused: bool,
}

impl Seat {
    /// Seat `side` of the room that a key makes; `entropy` must be unforeseeable.
    pub fn new(key: &Key, side: u8, entropy: &Key) -> Self {
        let of = |side: u8| pair(&Key::new(key.derive("seat").with(&[side]).first()));
        let ((secret, seat), (_, other)) = (of(side), of(1 - side));
        let join = Join { side, seat, other: name(&other), cookie: [0; 16], proof: [0; 16], nonce: [0; 8] };
        let entropy = Key::new(entropy.derive("seat").first());
        let (nonces, sent, welcomed) = Default::default();
        let (seated, other, refused) = Default::default();
        Self { join, secret, nonces, entropy, drawn: 0, sent, welcomed, seated, other, seen: None, refused }
    }

    /// Whether the other seat is taken.
    pub fn other_is_there(&self, now: Instant) -> bool {
        self.is_seated(now) && self.other
    }

    /// Whether this one is.
    pub fn is_seated(&self, now: Instant) -> bool {
        self.seated && self.welcomed.is_some_and(|at| now.saturating_duration_since(at) < GONE)
    }

    /// The join that is due; `hurries` where the relay is silent though it should not be.
    pub fn poll(&mut self, now: Instant, hurries: bool) -> Option<[u8; Join::LEN]> {
        let every = if hurries || !self.other_is_there(now) { HURRY } else { KEEP };
        if self.sent.is_some_and(|at| now.saturating_duration_since(at) < every) {
            return None;
        }
        self.drawn += 1;
        self.join.nonce = self.entropy.derive("nonce").with(&self.drawn.to_le_bytes()).first();
        self.nonces.truncate(UNDER_WAY - 1);
        self.nonces.push_front(self.join.nonce);
        self.sent = Some(now);
        Some(self.join.emit())
    }

    /// Takes a welcome, if it answers one of the newest joins; whether it is to be joined again at once, with a new cookie.
    pub fn hear(&mut self, now: Instant, datagram: &[u8]) -> Option<bool> {
        let welcome = Welcome::parse(datagram).filter(|welcome| self.nonces.contains(&welcome.nonce))?;
        let newer = welcome.cookie != self.join.cookie;
        let again = !welcome.seated && newer;
        if newer {
            self.join.cookie = welcome.cookie;
            self.join.proof = proof(&self.secret, &welcome.place, &welcome.cookie);
        }
        self.welcomed = Some(now);
        // A cookie that has become old costs no seat.
        if !again {
            (self.seated, self.other, self.refused) = (welcome.seated, welcome.other, welcome.refused);
        } else {
            self.sent = None;
        }
        self.seen = Some(welcome.seen);
        Some(again)
    }
}
