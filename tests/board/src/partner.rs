//! host-sim's live peer at the other end of the wire, in place of a second board: the same bytes, in virtual time.
//!
//! It is peer 2 (or 1) under that board's addresses, speaks UDP and answers ARP; what it says and takes is
//! [`Node`]'s, the lines that `host-sim peer` runs.

use haptic_protocol::key::Key;
use haptic_sim::node::Node;
use haptic_sim::scene::Scene;
use host_sim::Error;

use crate::pc::{board_ip, board_mac, peers_key, resolved, udp};

/// Port of the flow, at both ends.
const FLOW: u16 = 7701;

/// host-sim's peer as a partner on the wire.
#[derive(Debug)]
pub struct Partner {
    /// The peer with its device and link.
    pub node: Node,
    number: usize,
    /// Frames that wait to go out.
    out: Vec<Vec<u8>>,
    /// Flow datagrams that it did not take.
    pub refused: u64,
}

impl Partner {
    /// Peer `number` (1 or 2) of the scene, calling.
    ///
    /// # Errors
    /// What host-sim refuses.
    pub fn new(scene: &Scene, number: usize) -> Result<Self, Error> {
        let node = Node::new(scene, number as u8, peers_key(), [0x77; Key::LEN])?;
        Ok(Self { node, number, out: Vec::new(), refused: 0 })
    }

    /// Takes a frame from the wire.
    pub fn hear(&mut self, now_ns: u64, frame: &[u8]) {
        let (mac, ip) = (board_mac(self.number), board_ip(self.number));
        self.out.extend(resolved(frame, mac, ip));
        let ours =
            frame.get(12..14) == Some(&[0x08, 0x00]) && frame.get(..6) == Some(&mac) && frame.get(30..34) == Some(&ip);
        if !ours || frame.get(36..38) != Some(&FLOW.to_be_bytes()) {
            return;
        }
        let length = usize::from(u16::from_be_bytes([frame[38], frame[39]]));
        if let Some(payload) = frame.get(42..34 + length) {
            self.refused += u64::from(self.node.receive(now_ns / 1000, &mut payload.to_vec()).is_err());
        }
    }

    /// One control period; the frames that leave.
    pub fn tick(&mut self, now_ns: u64) -> Vec<Vec<u8>> {
        let end = |number| (board_mac(number), board_ip(number), FLOW);
        let (own, other) = (end(self.number), end(3 - self.number));
        let mut out = std::mem::take(&mut self.out);
        self.node.tick(now_ns / 1000, |bytes| out.push(udp(own, other, bytes)));
        out
    }
}
