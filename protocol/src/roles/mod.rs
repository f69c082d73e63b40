//! Roles: what a peer is in a shared haptic environment (Buttolo, Oboe & Hannaford 1997, §3; THEORY §6).
//!
//! A role is a state machine without I/O, like everything in this crate, and has the shape of [`Role`]: `receive` takes a message
//! and who it is from, `poll` lets time pass, both put what is to be said into an [`Out`], `take_notice` says what has happened.
//! Time is µs on the peer's own clock, which may start anywhere and must not go backwards. Messages have fixed little-endian
//! layouts; those of at most 48 bytes travel as [`crate::wire::Event`]s, whose `code` names the role ([`Carried`]); a decoder
//! takes any bytes and never panics.
//! The static world is too large for events: it has message kinds of its own, and its client asks again for what did not come.
//!
//! **What a role needs from its carrier**: that a message is what its sender said and that the sender is who it seems to be.
//! A sealed [`crate::link::Link`] promises both. No role counts on a message to arrive, once, in order or soon: whatever
//! must arrive is said again until it is answered, and whatever could come twice or late carries a number that tells.
//! So a session that breaks, and the events that are dropped with a peer that starts anew, cost time and nothing else.
//! Reliable events make the common case quick; they are not what makes it safe.

use heapless::Deque;

use crate::wire::{Error, Event, Message, PeerId};

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

/// What a peer is in a shared environment, as whoever drives it sees it.
///
/// **How it is driven**, on sockets or in virtual time: one driver brings the clock and carries the messages.
///
/// 1. What has come goes in with [`Role::receive`], one message at a time, with the number of the peer that the carrier found it
///    to be from. [`Carried::read`] makes the message of what a link has brought.
/// 2. Once a control or packet period, and after that, [`Role::poll`] lets time pass. Nothing has to be called at an exact time;
///    a late call makes the peer slow and nothing else.
/// 3. Both say what they have to say into an [`Out`] on the way: a closure that hands it to the network at once, or an [`Outbox`].
///    [`Carried::carry`] makes of it what a link takes. What is lost is said again by the role itself.
/// 4. [`Role::take_notice`], until there is none, says what has happened to the user, who answers with the methods that each
///    role has of its own (`ask`, `release`, `hit` …).
///
/// A crash is a new value of the same type; what it must still know comes back in by the role's own record.
pub trait Role {
    /// What it understands.
    type Hears;
    /// What it says.
    type Says;
    /// What it tells its user.
    type Notice;

    /// Takes a message of the peer `from`.
    fn receive(&mut self, now_us: u64, from: PeerId, message: &Self::Hears, out: &mut dyn Out<Self::Says>);

    /// Lets time pass.
    fn poll(&mut self, now_us: u64, out: &mut dyn Out<Self::Says>);

    /// The oldest notice that has not been told.
    fn take_notice(&mut self) -> Option<Self::Notice> {
        None
    }
}

/// A message of a role as a link carries it.
pub trait Carried: Sized {
    /// The message about `object` as the wire has it; a role that has one object only leaves the number out.
    ///
    /// A [`Message::Event`] is for [`crate::link::Link::push_event`]: once and in order. Everything else is sent once.
    fn carry(&self, object: u16) -> Result<Message, Error>;

    /// The object and the message, if the wire brought one of this role.
    fn read(message: &Message) -> Option<(u16, Self)>;
}

/// All that such a message says is to arrive.
macro_rules! carried_by_events {
    ($Message:ident) => {
        impl $crate::roles::Carried for $Message {
            fn carry(&self, object: u16) -> Result<$crate::wire::Message, $crate::error::Error> {
                self.event(object).map($crate::wire::Message::Event)
            }

            fn read(message: &$crate::wire::Message) -> Option<(u16, Self)> {
                let $crate::wire::Message::Event(event) = message else { return None };
                Self::parse(event).ok()
            }
        }
    };
}
pub(crate) use carried_by_events;

/// Takes what a role says, on its way to a peer: an [`Outbox`], or any closure.
pub trait Out<M> {
    /// Takes a message in charge; it may be lost.
    fn send(&mut self, to: PeerId, message: M);
}

impl<M, F: FnMut(PeerId, M)> Out<M> for F {
    fn send(&mut self, to: PeerId, message: M) {
        self(to, message);
    }
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

impl<M, const N: usize> Out<M> for Outbox<M, N> {
    fn send(&mut self, to: PeerId, message: M) {
        if self.queue.push_back((to, message)).is_err() {
            self.dropped = self.dropped.saturating_add(1);
        }
    }
}

impl<M, const N: usize> Default for Outbox<M, N> {
    fn default() -> Self {
        Self::new()
    }
}
