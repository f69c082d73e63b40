//! Several peers that write to each other: clocks of their own, and from each to each other a line with a fate of its own.
//!
//! Messages cross as the bytes of their events; a broken one does not pass the seal, and so never arrives.

use haptic_protocol::wire::Event;

use super::rule::{Direction, Rule, SeededRule};
use crate::rng::Rng;
use crate::scene::Network;

/// A message between two of several peers.
#[derive(Clone, Debug)]
pub struct Letter {
    /// Who sent it.
    pub from: usize,
    /// Whom it is for.
    pub to: usize,
    /// What it says.
    pub event: Event,
}

/// A clock that starts anywhere and runs fast or slow.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    /// What it shows in the beginning, µs.
    pub start_us: u64,
    /// How fast it runs; 1 is true.
    pub rate: f64,
}

impl Clock {
    /// What it shows at this true time, µs.
    pub fn at(self, true_us: u64) -> u64 {
        self.start_us + (true_us as f64 * self.rate) as u64
    }
}

/// The lines between any two of several peers.
#[derive(Clone, Debug)]
pub struct Mesh {
    peers: usize,
    lines: Vec<SeededRule>,
}

impl Mesh {
    /// Lines that all do what `network` says of the way from 1 to 2, each from a seed of its own; `packet_s` is what
    /// reordering counts in.
    pub fn new(peers: usize, network: Network, packet_s: f64, rng: &mut Rng) -> Self {
        let mut line = |_| {
            let network = Network { seed: rng.below(1 << 32) as u32, ..network };
            SeededRule::new(network, Direction::OneToTwo, packet_s)
        };
        Self { peers, lines: (0..peers * peers).map(&mut line).collect() }
    }

    /// How long each copy takes of what `from` sends `to` at `now_us`, µs; none, and it is lost.
    pub fn delays_us(&mut self, from: usize, to: usize, now_us: u64) -> Vec<u64> {
        let arrivals = self.lines[from * self.peers + to].decide(0, 1_000 * now_us).copies();
        let whole = arrivals.iter().filter(|arrival| !arrival.corrupt);
        whole.map(|arrival| arrival.delay_ns / 1_000).collect()
    }
}
