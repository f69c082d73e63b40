//! What goes up to the server and down to a client in one packet period, and how many bytes it is, sealed.
//!
//! Each part is a datagram of its own: pushes and motions are flow, a hand-over message is an event that says itself again and
//! is not acknowledged.

use cohold_core::num::Motion;
use cohold_protocol::wire::{Event, Moved, PeerId, Push, SEAL_LEN};

use super::MOST_USERS;
use super::bounder::Bound;
use crate::roles::Carried as _;
use crate::roles::cooperative::{Body, Message};

/// Bytes of a sealed hand-over message; it says itself again, nobody acknowledges it.
fn said_bytes(message: &Message) -> usize {
    SEAL_LEN + message.event(0).map_or(Event::MAX_LEN, |event| event.emitted_len())
}

/// What a client sends to the server.
#[derive(Clone, Copy, Debug)]
pub(super) struct Up {
    pub(super) push: Push,
    /// Where contact is computed at the server: the device, and with what gains.
    pub(super) sensed: Option<(Motion<f64>, Bound<f64>)>,
    /// Of the client that has the engine, for the others.
    pub(super) states: Option<[Moved; MOST_USERS]>,
    pub(super) say: Option<Message>,
}

/// What the server sends to a client.
#[derive(Clone, Copy, Debug)]
pub(super) struct Down {
    pub(super) state: Option<Moved>,
    /// Where contact is computed at the server: the force on the object.
    pub(super) force_n: Option<f64>,
    /// For the client that has the engine: what the others push with.
    pub(super) pushes: Option<[Option<Push>; MOST_USERS]>,
    pub(super) say: Option<Message>,
}

/// A packet in either direction.
#[derive(Clone, Copy, Debug)]
pub(super) enum Packet {
    Up(Up),
    Down(Down),
}

/// The role's name for a client.
pub(super) fn peer(index: usize) -> PeerId {
    PeerId(index as u8 + 1)
}

pub(super) fn body(object: Motion<f64>) -> Body {
    Body { axes: [[object.position, object.velocity], [0.0; 2]] }
}

pub(super) fn motion([[position, velocity], _]: [[impl Into<f64>; 2]; 2]) -> Motion<f64> {
    Motion { position: position.into(), velocity: velocity.into() }
}

impl Up {
    /// Bytes of it all, of a client among `users`.
    pub(super) fn bytes(&self, users: usize) -> usize {
        let broadcast = self.states.map_or(0, |_| (users - 1) * (SEAL_LEN + Moved::LEN));
        SEAL_LEN + Push::LEN + broadcast + self.say.as_ref().map_or(0, said_bytes)
    }
}

impl Down {
    /// Bytes of it all. A force that comes down is as long as a push that goes up.
    pub(super) fn bytes(&self) -> usize {
        let pushes = self.pushes.iter().flatten().flatten().count() + usize::from(self.force_n.is_some());
        let state = self.state.map_or(0, |_| SEAL_LEN + Moved::LEN);
        state + pushes * (SEAL_LEN + Push::LEN) + self.say.as_ref().map_or(0, said_bytes)
    }
}
