//! A partner far away: the PC beside the board is its partner on the wire and opens nothing ([`Bridge`]); it meets cohold's peer, in virtual time.
//!
//! Between the two are a meeting place and, unless it is cut, a direct path. Nothing of the board is told of any of this.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use cohold_homes::Way;
use cohold_homes::bridge::Bridge;
use cohold_homes::carrier::{Carrier, Config};
use cohold_homes::place::Place;
use cohold_protocol::key::Key;

use crate::pc::peers_key;

/// One way by the meeting place, in two halves, and from end to end, ns.
const RELAYED_NS: u64 = 40_000_000;
const DIRECT_NS: u64 = 8_000_000;

/// All between a board and a partner far away.
#[derive(Debug)]
pub struct Far {
    start: Instant,
    /// On the PC beside the board.
    pub bridge: Bridge,
    /// The board's, on that PC, and the partner's.
    carriers: [Carrier; 2],
    at: [SocketAddr; 2],
    meet: SocketAddr,
    place: Place,
    /// When it comes, ns, from, to, what.
    under_way: Vec<(u64, SocketAddr, SocketAddr, Vec<u8>)>,
    /// For the board, and for the partner.
    came: [Vec<Vec<u8>>; 2],
    /// There is no direct path.
    pub cut: bool,
}

impl Far {
    /// Of the board that has this number (1 or 2) and this address.
    ///
    /// # Panics
    /// Never: the addresses are.
    pub fn new(number: usize, board: SocketAddr) -> Self {
        let (start, side) = (Instant::now(), number as u8 - 1);
        let [meet, pc, partner] =
            ["203.0.113.1:4000", "203.0.113.11:4001", "203.0.113.12:4001"].map(|at| at.parse().expect("an address"));
        let carrier = |side, base| {
            let config = Config { key: peers_key(), side, meet, bases: vec![base], mapped: None, relay_only: false };
            Carrier::new(config, &Key::new([side + 1; Key::LEN]), start)
        };
        let carriers = [carrier(side, pc), carrier(1 - side, partner)];
        let place = Place::new(&Key::new([3; Key::LEN]), start);
        let (under_way, came, cut) = Default::default();
        let bridge = Bridge::new(board, start);
        Self { start, bridge, carriers, at: [pc, partner], meet, place, under_way, came, cut }
    }

    /// Which way flow goes at both ends.
    pub fn ways(&self) -> [Way; 2] {
        self.carriers.each_ref().map(Carrier::way)
    }

    fn post(&mut self, now_ns: u64, from: SocketAddr, sent: Vec<(SocketAddr, Vec<u8>)>) {
        for (to, bytes) in sent {
            let direct = from != self.meet && to != self.meet;
            if !(direct && self.cut) {
                let takes_ns = if direct { DIRECT_NS } else { RELAYED_NS / 2 };
                self.under_way.push((now_ns + takes_ns, from, to, bytes));
            }
        }
    }

    /// Gives a carrier its turn, and what it then says to the network.
    fn carry(
        &mut self,
        now_ns: u64,
        end: usize,
        turn: impl FnOnce(&mut Carrier, Instant, &mut cohold_homes::Send<'_>),
    ) {
        let mut sent = Vec::new();
        let now = self.start + Duration::from_nanos(now_ns);
        turn(&mut self.carriers[end], now, &mut |to, bytes: &[u8]| sent.push((to, bytes.to_vec())));
        self.post(now_ns, self.at[end], sent);
    }

    /// The PC takes a datagram that came to the port of the flow.
    pub fn hear(&mut self, now_ns: u64, from: SocketAddr, datagram: &[u8]) {
        if self.bridge.hear_board(self.start + Duration::from_nanos(now_ns), from, datagram) {
            self.carry(now_ns, 0, |carrier, now, send| _ = carrier.send(now, datagram, send));
        }
    }

    /// What an end's carrier has for the link.
    fn hand_over(&mut self, now_ns: u64, end: usize, bytes: Vec<u8>) {
        if end == 1 || self.bridge.hear_far(self.start + Duration::from_nanos(now_ns), &bytes) {
            self.came[end].push(bytes);
        }
    }

    /// A period: takes what the partner says; gives what has come for the board, and for the partner.
    pub fn step(&mut self, now_ns: u64, said: &[Vec<u8>]) -> [Vec<Vec<u8>>; 2] {
        let (come, wait) = std::mem::take(&mut self.under_way).into_iter().partition(|(at, ..)| *at <= now_ns);
        self.under_way = wait;
        for (_, from, to, bytes) in come as Vec<(u64, SocketAddr, SocketAddr, Vec<u8>)> {
            if let Some(end) = self.at.iter().position(|at| *at == to) {
                let mut is_flow = false;
                self.carry(now_ns, end, |carrier, now, send| is_flow = carrier.hear(now, from, &bytes, send));
                if is_flow {
                    self.hand_over(now_ns, end, bytes);
                }
            } else {
                let (mut sent, now) = (Vec::new(), self.start + Duration::from_nanos(now_ns));
                self.place.hear(now, from, &bytes, &mut |to, bytes: &[u8]| sent.push((to, bytes.to_vec())));
                self.post(now_ns, self.meet, sent);
            }
        }
        for end in 0..2 {
            while let Some(bytes) = self.carriers[end].release(self.start + Duration::from_nanos(now_ns)) {
                self.hand_over(now_ns, end, bytes);
            }
            self.carry(now_ns, end, |carrier, now, send| carrier.poll(now, send));
        }
        for bytes in said {
            self.carry(now_ns, 1, |carrier, now, send| _ = carrier.send(now, bytes, send));
        }
        std::mem::take(&mut self.came)
    }
}
