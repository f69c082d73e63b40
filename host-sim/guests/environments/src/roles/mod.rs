//! Roles: what a peer is in a shared haptic environment (Buttolo, Oboe & Hannaford 1997, §3; THEORY §6).
//!
//! A role is a state machine without I/O, like everything in this crate, and has the shape of [`Role`]: `receive` takes a message
//! and who it is from, `poll` lets time pass, both put what is to be said into an [`Out`], `take_notice` says what has happened.
//! Time is µs on the peer's own clock, which may start anywhere and must not go backwards. Messages have fixed little-endian
//! layouts; those of at most 48 bytes travel as [`cohold_protocol::wire::Event`]s, whose `code` names the role ([`Carried`]); a decoder
//! takes any bytes and never panics.
//! The static world is too large for events: it has message kinds of its own, and its client asks again for what did not come.
//!
//! **What a role needs from its carrier**: that a message is what its sender said and that the sender is who it seems to be.
//! A sealed [`cohold_protocol::link::Link`] promises both. No role counts on a message to arrive, once, in order or soon: whatever
//! must arrive is said again until it is answered, and whatever could come twice or late carries a number that tells.
//! So a session that breaks, and the events that are dropped with a peer that starts anew, cost time and nothing else.
//! Reliable events make the common case quick; they are not what makes it safe.
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

use heapless::Deque;

use cohold_protocol::wire::{Error, Event, Message, PeerId, Sample};

pub mod collaborative;
pub mod cooperative;
mod messages;
pub mod squash;
pub mod static_scene;

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
    /// The messages that the role takes and sends.
    type Message;
    /// The notices that the role gives its user.
    type Notice;

    /// Takes a message of the peer `from`.
    fn receive(&mut self, now_us: u64, from: PeerId, message: &Self::Message, out: &mut dyn Out<Self::Message>);

    /// Does what is due at time `now_us`: repeats, expiries and answers.
    fn poll(&mut self, now_us: u64, out: &mut dyn Out<Self::Message>);

    /// The oldest notice that has not been taken.
    fn take_notice(&mut self) -> Option<Self::Notice> {
        None
    }
}

/// A message of a role as a link carries it.
pub trait Carried: Sized {
    /// Event code of the role: what [`cohold_protocol::wire::Event::code`] says.
    const CODE: u16;

    /// The message about `object` as an event; a role that has one object only leaves the number out.
    fn event(&self, object: u16) -> Result<Event, Error>;

    /// The object and the message that an event holds.
    fn parse(event: &Event) -> Result<(u16, Self), Error>;

    /// Whether the newest counts, and none has to arrive.
    fn is_flow(&self) -> bool;

    /// The message about `object` as the wire has it: an event that is to arrive, for [`cohold_protocol::link::Link::push_event`], or a
    /// sample, which is sent once.
    fn carry(&self, object: u16) -> Result<Message, Error> {
        let event = self.event(object)?;
        Ok(if self.is_flow() { Sample::new(event.code, event.payload())?.into() } else { event.into() })
    }

    /// The object and the message, if the wire brought one of this role.
    fn read(message: &Message) -> Option<(u16, Self)> {
        match message {
            Message::Event(event) => Self::parse(event).ok(),
            Message::Sample(sample) => {
                Self::parse(&Event::new(sample.code, sample.payload()).ok()?).ok().filter(|(_, said)| said.is_flow())
            }
            _ => None,
        }
    }
}

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

/// What a role wants to say, oldest first, and to whom. Full, it drops what is newest, as a network might.
pub type Outbox<M, const N: usize> = Deque<(PeerId, M), N>;

impl<M, const N: usize> Out<M> for Outbox<M, N> {
    fn send(&mut self, to: PeerId, message: M) {
        let _ = self.push_back((to, message));
    }
}
