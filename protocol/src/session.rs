//! One session: the keys that two ephemerals give, in both directions, and what has been taken under them.
//!
//! Both ephemerals are fresh, so both ends contribute to every key: one that forgot everything (a reboot) or whose randomness
//! failed still gets keys that were never used, from an end whose randomness did not. Parameters and incarnations enter too, so
//! that peers which disagree about anything cannot read each other.
//!
//! **Invariant**: the replay window belongs to the keys; there is never a window without them or a second one for them.
//!
//! **Freshness**: every sealed message echoes the newest time of the receiver's clock that its sender had opened in this session
//! ([`Stamps`]). So the receiver knows how old it is at the most, the way there and back and what the sender waited, from its own
//! clock alone; an echo also says that the other end opens what is sealed here.
//!
//! **Sealing** is ChaCha20-Poly1305 ([`crate::cipher`]). Each direction has its own keys, so that what a peer sent is never opened by
//! itself. The sequence number is the nonce and also picks the key: every 2²⁰ datagrams (2.3 h at one each 8 ms) both ends move on
//! to the next traffic key without a word about it. The header is authenticated, the message encrypted, both or neither.
//!
//! **Invariants**: [`Counter`] hands out a number once and lives as long as its peer, across sessions, so that no key
//! meets a nonce twice; a datagram whose tag is wrong leaves no trace. There is no way to send a message unsealed.

use core::fmt;

use crate::cipher::Cipher;
use crate::replay::{SEQUENCE_LIMIT, Window};
use crate::wire::{self, Ephemeral, Greeting, Header, Message, PeerId, Stamps, TABLES, TAG_LEN, TableHash, VERSION};
use crate::{
    ends::Ends,
    error::Refusal,
    key::{Key, NONCE_LEN, Nonce},
};

/// What one end puts into a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Offer {
    pub ephemeral: Ephemeral,
    pub incarnation: u64,
}

/// The settings of both ends of a session, as a greeting carries them.
pub(crate) type Agreed = (u8, [TableHash; TABLES]);

#[cfg_attr(test, derive(Clone))]
pub(crate) struct Session {
    ends: Ends,
    pub(crate) remote: Offer,
    number: u32,
    outward: Direction,
    inward: Direction,
    window: Window,
    first: u64,
    taken: u64,
    /// This end's clock when the session began, µs; no echo is older.
    pub(crate) began_us: u64,
    /// The other end's clock in its newest datagram, µs: what the next one from here echoes.
    stamp_us: u64,
    /// What the newest datagram said of the lease, and the time of this end's clock that it echoed, µs.
    heard: Option<(u8, Option<u64>)>,
    confirmed: bool,
}

/// What an end says with every message.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Says {
    /// The byte about the lease ([`crate::lease`]).
    pub lease: u8,
    /// Something is said in every packet period.
    pub is_eager: bool,
    /// Shorter messages are made this long, bytes.
    pub least: usize,
}

/// A sealed datagram, opened.
#[derive(Debug)]
pub(crate) struct Opened<'a> {
    /// The message as bytes.
    pub message: &'a [u8],
    /// How old it is at the most, µs; `None`: it echoes nothing that was said from here in this session.
    pub age_us: Option<u64>,
    /// When it was sealed, µs of the other end's clock.
    pub sealed_us: u64,
}

impl fmt::Debug for Session {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { number, taken, window, began_us, stamp_us, confirmed, .. } = self;
        write!(f, "Session({number:08x}, {taken} taken, {window:?}, {began_us}, {stamp_us}, {confirmed})")
    }
}

impl Session {
    /// The session that two offers, the local one first, make under the shared key and the secret that their ephemerals agree on.
    pub(crate) fn new(
        pre_shared: &Key,
        ends: Ends,
        [local, remote]: [Offer; 2],
        secret: &Key,
        (count, tables): &Agreed,
        now: u64,
    ) -> Self {
        let local_is_low = ends.local < ends.remote;
        let (low, high) = if local_is_low { (ends.local, ends.remote) } else { (ends.remote, ends.local) };
        let (of_low, of_high) = if local_is_low { (local, remote) } else { (remote, local) };
        let mut derivation = pre_shared
            .derive("session")
            .with(&[VERSION, low.0, high.0])
            .with(&of_low.ephemeral)
            .with(&of_high.ephemeral)
            .with(&of_low.incarnation.to_le_bytes())
            .with(&of_high.incarnation.to_le_bytes())
            .with(secret.bytes())
            .with(&[*count]);
        for table in tables {
            derivation = derivation.with(table);
        }
        let secret = derivation.end();
        Self {
            ends,
            remote,
            number: u32::from_le_bytes(secret.derive("number").first()),
            outward: Direction::new(&secret, ends.local, ends.remote),
            inward: Direction::new(&secret, ends.remote, ends.local),
            window: Window::default(),
            first: 0,
            taken: 0,
            began_us: now.max(1),
            stamp_us: 0,
            heard: None,
            confirmed: false,
        }
    }

    /// Whether a greeting is of what the other end has put into this session.
    pub(crate) fn is_named_by(&self, greeting: &Greeting) -> bool {
        self.remote == Offer { ephemeral: greeting.ephemeral, incarnation: greeting.incarnation }
    }

    /// Number by which the session's datagrams are distinguished; not secret.
    pub(crate) fn number(&self) -> u32 {
        self.number
    }

    /// The other end has answered in this session: it is there, now, and has these keys.
    pub(crate) fn is_confirmed(&self) -> bool {
        self.confirmed
    }

    pub(crate) fn confirm(&mut self) {
        self.confirmed = true;
    }

    /// The newest time of the other end's clock that was heard in this session, µs.
    pub(crate) fn stamp_us(&self) -> Option<u64> {
        (self.stamp_us > 0).then_some(self.stamp_us)
    }

    /// How long ago this end's clock showed `stamp_us`, µs; `None` if that was not in this session.
    pub(crate) fn age_us(&self, now: u64, stamp_us: u64) -> Option<u64> {
        let now = now.max(self.began_us);
        (self.began_us..=now).contains(&stamp_us).then(|| now - stamp_us)
    }

    /// What the newest datagram said of the lease, and the newest time of this end's clock that its sender knew, µs.
    pub(crate) fn heard(&self) -> Option<(u8, Option<u64>)> {
        self.heard
    }

    /// Seals `message` into the front of `out` at `now` and gives the datagram's length; zeros are put behind a message that is
    /// shorter than `least` bytes.
    pub(crate) fn seal(
        &mut self,
        counter: &mut Counter,
        now: u64,
        says: Says,
        message: &Message,
        out: &mut [u8],
    ) -> Result<usize, Refusal> {
        let Ends { local: from, remote: to } = self.ends;
        let header = Header { from, to, session: self.number, sequence: counter.draw()? };
        let sealed_us = now.max(self.began_us);
        let stamps = Stamps { sealed_us, echo_us: self.stamp_us, padding: 0, lease: says.lease };
        self.outward.seal(&header, stamps, message, says.least, out)
    }

    /// Opens, in place, what [`Header::parse`] took apart.
    pub(crate) fn open<'a>(
        &mut self,
        now: u64,
        header: &Header,
        head: &[u8; Header::LEN],
        sealed: &'a mut [u8],
    ) -> Result<Opened<'a>, Refusal> {
        if header.session != self.number {
            return Err(Refusal::OtherSession);
        }
        self.window.check(header.sequence)?;
        let body = self.inward.open(header, head, sealed)?;
        let newest = self.window.newest();
        self.window.take(header.sequence)?;
        if self.taken == 0 {
            self.first = header.sequence;
        }
        self.first = self.first.min(header.sequence);
        self.taken = self.taken.saturating_add(1);
        let length = wire::Error::length("stamps", Stamps::LEN, body.len());
        let (stamps, message) = body.split_at_checked(Stamps::LEN).ok_or(length)?;
        let Stamps { sealed_us, padding, echo_us, lease } = Stamps::parse(stamps)?;
        let age_us = self.age_us(now, echo_us);
        if newest.is_none_or(|newest| header.sequence > newest) {
            self.stamp_us = sealed_us;
            self.heard = Some((lease, age_us.map(|_| echo_us)));
        }
        let without = message.len().saturating_sub(padding.into());
        let (message, zeros) = message.split_at_checked(without).unwrap_or_default();
        if zeros.len() != usize::from(padding) || zeros.iter().any(|byte| *byte != 0) {
            return Err(wire::Error::Reserved("padding").into());
        }
        Ok(Opened { message, age_us, sealed_us })
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

/// How many sequence numbers share a traffic key, as a power of 2.
pub(crate) const EPOCH_BITS: u32 = 20;

#[derive(Debug, Default)]
#[cfg_attr(test, derive(Clone))]
pub(crate) struct Counter {
    next: u64,
}

impl Counter {
    /// Starts at `next` instead of 0, to try what happens late in a peer's life.
    #[cfg(test)]
    pub(crate) fn starting_at(next: u64) -> Self {
        Self { next }
    }

    pub(crate) fn draw(&mut self) -> Result<u64, Refusal> {
        if self.next >= SEQUENCE_LIMIT {
            return Err(Refusal::Exhausted);
        }
        let drawn = self.next;
        self.next += 1;
        Ok(drawn)
    }
}

#[cfg_attr(test, derive(Clone))]
pub(crate) struct Direction {
    base: Key,
    epoch: u64,
    cipher: Cipher,
}

impl Direction {
    /// The direction from one peer to another, under a session's secret.
    pub(crate) fn new(session_secret: &Key, from: PeerId, to: PeerId) -> Self {
        let base = session_secret.derive("direction").with(&[from.0, to.0]).end();
        let cipher = Self::traffic(&base, 0);
        Self { base, epoch: 0, cipher }
    }

    fn traffic(base: &Key, epoch: u64) -> Cipher {
        Cipher::new(&base.derive("epoch").with(&epoch.to_le_bytes()).end())
    }

    fn nonce(sequence: u64) -> Nonce {
        let mut nonce = [0; NONCE_LEN];
        if let Some(low) = nonce.last_chunk_mut() {
            *low = sequence.to_le_bytes();
        }
        nonce
    }

    /// Writes header, sealed message and tag to the front of `out` and gives their length.
    ///
    /// The header's sequence must be fresh from the sender's one [`Counter`].
    pub(crate) fn seal(
        &mut self,
        header: &Header,
        mut stamps: Stamps,
        message: &Message,
        least: usize,
        out: &mut [u8],
    ) -> Result<usize, Refusal> {
        let epoch = header.sequence >> EPOCH_BITS;
        if epoch != self.epoch {
            self.cipher = Self::traffic(&self.base, epoch);
            self.epoch = epoch;
        }
        let too_short = wire::Error::length("datagram", wire::SEAL_LEN, out.len());
        let (head, rest) = out.split_first_chunk_mut::<{ Header::LEN }>().ok_or(too_short)?;
        header.emit(head)?;
        let length = message.emit(rest.get_mut(Stamps::LEN..).unwrap_or_default())?;
        let padding = least.saturating_sub(length).min(Stamps::MAX_PADDING);
        stamps.padding = padding as u8;
        stamps.emit(rest)?;
        let len = Stamps::LEN + length + padding;
        let (body, rest) = rest.split_at_mut_checked(len).ok_or(too_short)?;
        body.get_mut(len - padding..).unwrap_or_default().fill(0);
        let end = rest.first_chunk_mut::<TAG_LEN>().ok_or(too_short)?;
        *end = self.cipher.seal(Self::nonce(header.sequence), head, body)?;
        Ok(Header::LEN + len + TAG_LEN)
    }

    /// Opens what [`Header::parse`] took apart, in place; the message as bytes.
    pub(crate) fn open<'a>(
        &mut self,
        header: &Header,
        head: &[u8; Header::LEN],
        sealed: &'a mut [u8],
    ) -> Result<&'a [u8], Refusal> {
        let length = wire::Error::length("sealed", TAG_LEN, sealed.len());
        let (body, tag) = sealed.split_last_chunk_mut::<TAG_LEN>().ok_or(length)?;
        let (nonce, tag) = (Self::nonce(header.sequence), *tag);
        let epoch = header.sequence >> EPOCH_BITS;
        if epoch == self.epoch {
            self.cipher.open(nonce, head, body, tag)?;
        } else {
            let cipher = Self::traffic(&self.base, epoch);
            cipher.open(nonce, head, body, tag)?;
            // Only the owner of the key gets here, so only it can move the epoch.
            if epoch > self.epoch {
                self.cipher = cipher;
                self.epoch = epoch;
            }
        }
        Ok(body)
    }
}

#[cfg(test)]
#[path = "../tests/inside/session.rs"]
mod tests;
