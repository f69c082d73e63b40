//! Roles: what a peer is in a shared haptic environment (Buttolo, Oboe & Hannaford 1997, §3; THEORY §6).
//!
//! | module | role |
//! |---|---|
//! | [`static_scene`] | a server holds the environment, a client downloads it and renders locally |
//! | [`collaborative`] | one at a time edits an object: a lock at a central server, or a token that goes round |
//! | [`cooperative`] | one dynamics engine, at the server or at a client, and who has it |
//! | [`squash`] | one ball, 2 to 8 players, one at a time hits it |
//!
//! A role is a state machine without I/O, like everything in this crate: `receive` takes a message and who it is from, `poll`
//! lets time pass, both put what is to be said into an [`Outbox`]. Time is µs on the peer's own clock, which may start
//! anywhere and must not go backwards. Messages have fixed little-endian layouts of at most 48 bytes and travel as
//! [`crate::wire::Event`]s, whose `code` names the role; a decoder takes any bytes and never panics.
//! The static world is too large for events: it has message kinds of its own, and its client asks again for what did not come.
//!
//! **What a role needs from its carrier**: that a message is what its sender said and that the sender is who it seems to be.
//! A sealed [`crate::link::Link`] promises both. No role counts on a message to arrive, once, in order or soon: whatever
//! must arrive is said again until it is answered, and whatever could come twice or late carries a number that tells.
//! So a session that breaks, and the events that are dropped with a peer that starts anew, cost time and nothing else.
//! Reliable events make the common case quick; they are not what makes it safe.

use heapless::Deque;

use crate::wire::{Event, PeerId};

pub mod collaborative;
pub mod cooperative;
pub mod squash;
pub mod static_scene;

/// Event codes of the roles: what [`crate::wire::Event::code`] says.
pub mod code {
    /// [`super::collaborative::lock`].
    pub const LOCK: u16 = 0x0101;
    /// [`super::collaborative::ring`].
    pub const RING: u16 = 0x0102;
    /// [`super::squash`].
    pub const SQUASH: u16 = 0x0103;
    /// [`super::cooperative`].
    pub const COOPERATIVE: u16 = 0x0201;
}

/// What a role wants to say, oldest first, and to whom. Full, it drops what is newest and counts it, as a network might.
#[derive(Clone, Debug)]
pub struct Outbox<M, const N: usize> {
    queue: Deque<(PeerId, M), N>,
    dropped: u32,
}

impl<M, const N: usize> Outbox<M, N> {
    /// Nothing to say.
    pub const fn new() -> Self {
        Self { queue: Deque::new(), dropped: 0 }
    }

    /// Adds a message.
    pub fn send(&mut self, to: PeerId, message: M) {
        if self.queue.push_back((to, message)).is_err() {
            self.dropped = self.dropped.saturating_add(1);
        }
    }

    /// The oldest message, once.
    pub fn take(&mut self) -> Option<(PeerId, M)> {
        self.queue.pop_front()
    }

    /// Everything, oldest first, as the events that carry it; what does not fit into one is left out.
    pub fn events<E>(&mut self, event: impl Fn(&M) -> Result<Event, E>) -> impl Iterator<Item = (PeerId, Event)> {
        core::iter::from_fn(|| self.take()).filter_map(move |(to, message)| Some((to, event(&message).ok()?)))
    }

    /// Messages for which there was no room.
    pub fn dropped(&self) -> u32 {
        self.dropped
    }
}

impl<M, const N: usize> Default for Outbox<M, N> {
    fn default() -> Self {
        Self::new()
    }
}
