//! One session: the keys that two challenges give, in both directions, and what has been taken under them.
//!
//! Both challenges are fresh, so both ends contribute to every key: one that forgot everything (a reboot) or whose
//! randomness failed still gets keys that were never used. Parameters and incarnations enter too, so that peers which
//! disagree about anything cannot read each other.
//!
//! **Invariant**: the replay window belongs to the keys; there is never a window without them or a second one for them.

use core::fmt;

use crate::seal::{Counter, Direction};
use crate::wire::{Challenge, Greeting, Header, Message, TABLES, VERSION};
use crate::{ends::Ends, error::Refusal, key::Key, replay::Window};

/// What one end puts into a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Offer {
    pub challenge: Challenge,
    pub incarnation: u64,
}

/// What both ends of a session were told, as a greeting carries it.
pub(crate) type Agreed = (u8, [u64; TABLES]);

pub(crate) struct Session {
    ends: Ends,
    pub(crate) local: Offer,
    pub(crate) remote: Offer,
    number: u32,
    outward: Direction,
    inward: Direction,
    window: Window,
    first: u64,
    taken: u64,
}

impl fmt::Debug for Session {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Session({:08x}, {} taken, {:?})", self.number, self.taken, self.window)
    }
}

impl Session {
    /// The session that two offers make under the shared key.
    pub(crate) fn new(shared: &Key, ends: Ends, local: Offer, remote: Offer, (count, tables): &Agreed) -> Self {
        let local_is_low = ends.local < ends.remote;
        let (low, high) = if local_is_low { (ends.local, ends.remote) } else { (ends.remote, ends.local) };
        let (of_low, of_high) = if local_is_low { (local, remote) } else { (remote, local) };
        let mut derivation = shared
            .derive("session")
            .with(&[VERSION, low.0, high.0])
            .with(&of_low.challenge)
            .with(&of_high.challenge)
            .with(&of_low.incarnation.to_le_bytes())
            .with(&of_high.incarnation.to_le_bytes())
            .with(&[*count]);
        for table in tables {
            derivation = derivation.with(&table.to_le_bytes());
        }
        let secret = derivation.end();
        Self {
            ends,
            local,
            remote,
            number: u32::from_le_bytes(secret.derive("number").first()),
            outward: Direction::new(&secret, ends.local, ends.remote),
            inward: Direction::new(&secret, ends.remote, ends.local),
            window: Window::default(),
            first: 0,
            taken: 0,
        }
    }

    /// Whether a greeting's challenges are the two that made this session.
    pub(crate) fn is_named_by(&self, greeting: &Greeting) -> bool {
        self.remote.challenge == greeting.challenge && self.local.challenge == greeting.echo
    }

    /// What its datagrams are told apart by; not secret.
    pub(crate) fn number(&self) -> u32 {
        self.number
    }

    /// The other end has been heard under these keys: it is there, now, and has them.
    pub(crate) fn is_confirmed(&self) -> bool {
        self.taken > 0
    }

    /// Seals `message` into the front of `out` and gives the datagram's length.
    pub(crate) fn seal(&mut self, counter: &mut Counter, message: &Message, out: &mut [u8]) -> Result<usize, Refusal> {
        let Ends { local: from, remote: to } = self.ends;
        let header = Header { from, to, session: self.number, sequence: counter.draw()? };
        self.outward.seal(&header, message, out)
    }

    /// Opens, in place, what [`Header::parse`] took apart; the message as bytes.
    pub(crate) fn open<'a>(
        &mut self,
        header: &Header,
        head: &[u8; Header::LEN],
        sealed: &'a mut [u8],
    ) -> Result<&'a [u8], Refusal> {
        if header.session != self.number {
            return Err(Refusal::OtherSession);
        }
        self.window.check(header.sequence)?;
        let message = self.inward.open(header, head, sealed)?;
        self.window.take(header.sequence)?;
        if self.taken == 0 {
            self.first = header.sequence;
        }
        self.first = self.first.min(header.sequence);
        self.taken = self.taken.saturating_add(1);
        Ok(message)
    }

    /// Sealed datagrams taken so far; 2³² − 1 stands for more.
    pub(crate) fn taken(&self) -> u32 {
        u32::try_from(self.taken).unwrap_or(u32::MAX)
    }

    pub(crate) fn missing(&self) -> u32 {
        let Some(newest) = self.window.newest() else { return 0 };
        let sent = newest.saturating_sub(self.first).saturating_add(1);
        u32::try_from(sent.saturating_sub(self.taken)).unwrap_or(u32::MAX)
    }
}

#[cfg(test)]
#[path = "../tests/inside/session.rs"]
mod tests;
