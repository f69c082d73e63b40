//! From what a role says to the seats of an engine.

use cohold_protocol::wire::{MAX_DATAGRAM, Message, PeerId, SEAL_LEN};
use cohold_sim::engine::Out;
use cohold_sim::network::link::Payload;

use crate::roles::Carried;

/// A message that crosses a simulated network as a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing(pub Message);

impl Payload for Crossing {}

/// Takes what a role says about `object` to the seats of an engine, which have the peers' numbers.
pub fn said<M: Carried>(object: u16, out: &mut Out<'_, usize, Crossing>) -> impl FnMut(PeerId, M) {
    move |to: PeerId, message: M| {
        if let Ok(message) = message.carry(object) {
            out(usize::from(to.0), &Crossing(message));
        }
    }
}

/// Bytes of a sealed message.
pub(crate) fn sealed_len(message: &Message) -> usize {
    SEAL_LEN + message.emit(&mut [0; MAX_DATAGRAM]).unwrap_or(0)
}
