//! cohold's live peer at the other end of the wire, in place of a second board: the same bytes, in virtual time.
//!
//! It is peer 2 (or 1) under that board's addresses, speaks UDP and answers ARP; what it says and takes is
//! [`Node`]'s, the lines that `cohold peer` runs. Or it is far away, and only a PC is there ([`Far`]).

use std::net::SocketAddr;

use cohold_cli::Failure;
use cohold_live::node::Node;
use cohold_protocol::key::Key;
use cohold_sim::scene::Scene;

use crate::far::Far;
use crate::pc::{board_ip, board_mac, peers_key, resolved, udp};

/// Port of the flow, at both ends.
const FLOW: u16 = 7701;

/// cohold's peer as a partner on the wire.
#[derive(Debug)]
pub struct Partner {
    /// The peer with its device and link.
    pub node: Node,
    number: usize,
    /// Frames that wait to go out.
    out: Vec<Vec<u8>>,
    /// Flow datagrams that it did not take.
    pub refused: u64,
    /// What is between, where it is far away.
    pub far: Option<Far>,
}

impl Partner {
    /// Peer `number` (1 or 2) of the scene, calling.
    ///
    /// # Errors
    /// What cohold refuses.
    pub fn new(scene: &Scene, number: usize) -> Result<Self, Failure> {
        let node = <Node>::build(scene, number as u8, peers_key(), [0x77; Key::LEN])?;
        Ok(Self { node, number, out: Vec::new(), refused: 0, far: None })
    }

    /// This partner behind the PC that has its addresses on the wire.
    #[must_use]
    pub fn far(self) -> Self {
        let board = 3 - self.number;
        let far = Far::new(board, SocketAddr::from((board_ip(board), FLOW)));
        Self { far: Some(far), ..self }
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
        let Some(payload) = frame.get(42..34 + length) else { return };
        match (&mut self.far, frame[26..30].first_chunk::<4>()) {
            (Some(far), Some(ip)) => {
                let from = SocketAddr::from((*ip, u16::from_be_bytes([frame[34], frame[35]])));
                far.hear(now_ns, from, payload);
            }
            _ => self.receive(now_ns, &mut payload.to_vec()),
        }
    }

    fn receive(&mut self, now_ns: u64, datagram: &mut [u8]) {
        self.refused += u64::from(self.node.receive(now_ns / 1000, datagram).is_err());
    }

    /// One control period; the frames that leave.
    pub fn tick(&mut self, now_ns: u64) -> Vec<Vec<u8>> {
        let end = |number| (board_mac(number), board_ip(number), FLOW);
        let (own, other) = (end(self.number), end(3 - self.number));
        let mut said = Vec::new();
        self.node.tick(now_ns / 1000, |bytes| said.push(bytes.to_vec()));
        if let Some([for_board, for_partner]) = self.far.as_mut().map(|far| far.step(now_ns, &said)) {
            said = for_board;
            for_partner.into_iter().for_each(|mut datagram| self.receive(now_ns, &mut datagram));
        }
        let mut out = std::mem::take(&mut self.out);
        out.extend(said.iter().map(|bytes| udp(own, other, bytes)));
        out
    }
}
