//! Two links and the wire between them, impaired as a test asks, from one seed.

use cohold_protocol::ends::Ends;
use cohold_protocol::key::Key;
use cohold_protocol::link::{Config, Link, Notice, Stage};
use cohold_protocol::parameters::{Parameters, Table};
use cohold_protocol::wire::{AxisFlow, Event, Flow, MAX_DATAGRAM, Message, PeerId};

pub(crate) use super::random::Rng;

/// The packet period of every test, µs.
pub(crate) const PERIOD: u64 = 8_000;

/// The parameters of a peer with this coordination stiffness.
pub(crate) fn parameters(stiffness: f64) -> Parameters {
    let mut parameters = Parameters::new();
    parameters.add(Table::new("timing").number("control_period_s", 0.001).number("ticks_per_packet", 8.0)).unwrap();
    parameters.add(Table::new("coordination").number("stiffness_n_per_m", stiffness)).unwrap();
    parameters
}

pub(crate) fn config(local: u8, remote: u8, entropy: [u8; 32]) -> Config {
    Config {
        key: Key::new([7; 32]),
        ends: Ends { local: PeerId(local), remote: PeerId(remote) },
        packet_period_us: PERIOD as u32,
        parameters: parameters(1e4),
        entropy,
    }
}

/// What the network does to a datagram.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Impairment {
    pub(crate) loss: f64,
    pub(crate) duplicate: f64,
    /// Every datagram takes this long, µs …
    pub(crate) delay: u64,
    /// … and up to this much longer, so that they overtake each other.
    pub(crate) jitter: u64,
}

pub(crate) const CLEAN: Impairment = Impairment { loss: 0.0, duplicate: 0.0, delay: 500, jitter: 0 };

/// A datagram on its way.
struct InFlight {
    due: u64,
    to: usize,
    bytes: Vec<u8>,
}

/// Two peers and everything between them.
pub(crate) struct World {
    pub(crate) links: [Link; 2],
    pub(crate) rng: Rng,
    pub(crate) impairment: Impairment,
    /// µs since the beginning, on nobody's clock.
    pub(crate) now: u64,
    /// What each peer's clock showed at the beginning, and how fast it runs.
    pub(crate) clocks: [(u64, f64); 2],
    /// Peers that are switched off.
    pub(crate) off: [bool; 2],
    /// Peers that send no flow.
    pub(crate) quiet: [bool; 2],
    /// Directions that are cut: to peer 0, to peer 1.
    pub(crate) cut: [bool; 2],
    /// How much earlier than the impairment says it arrives at each peer, µs.
    pub(crate) ahead: [u64; 2],
    /// Every datagram that each peer ever sent, if wanted.
    pub(crate) log: Option<[Vec<Vec<u8>>; 2]>,
    pub(crate) flows: [Vec<Flow>; 2],
    pub(crate) events: [Vec<Event>; 2],
    pub(crate) notices: [Vec<Notice>; 2],
    in_flight: Vec<InFlight>,
    tick: u32,
}

impl World {
    pub(crate) fn new(seed: u64, impairment: Impairment) -> Self {
        let mut rng = Rng(seed);
        let links = [Link::new(config(1, 2, rng.bytes())).unwrap(), Link::new(config(2, 1, rng.bytes())).unwrap()];
        Self {
            links,
            rng,
            impairment,
            now: 0,
            clocks: [(5_000_000, 1.0), (77, 1.0)],
            off: [false; 2],
            quiet: [false; 2],
            cut: [false; 2],
            ahead: [0; 2],
            log: None,
            flows: [vec![], vec![]],
            events: [vec![], vec![]],
            notices: [vec![], vec![]],
            in_flight: vec![],
            tick: 0,
        }
    }

    /// Two peers that have run long enough to be fully engaged.
    pub(crate) fn engaged(seed: u64) -> Self {
        let mut world = Self::new(seed, CLEAN);
        world.run(300_000);
        assert!(world.is_engaged());
        world
    }

    /// What the clock of `peer` shows.
    pub(crate) fn clock(&self, peer: usize) -> u64 {
        let (start, rate) = self.clocks[peer];
        start + (self.now as f64 * rate) as u64
    }

    /// A peer forgets everything, as at a reset.
    pub(crate) fn restart(&mut self, peer: usize) {
        let numbers = [1, 2];
        self.links[peer] = Link::new(config(numbers[peer], numbers[1 - peer], self.rng.bytes())).unwrap();
    }

    pub(crate) fn send(&mut self, from: usize, bytes: &[u8]) {
        if let Some(log) = &mut self.log {
            log[from].push(bytes.to_vec());
        }
        let to = 1 - from;
        if self.cut[to] {
            return;
        }
        let copies = 1 + u64::from(self.rng.chance(self.impairment.duplicate));
        for _ in 0..copies {
            if !self.rng.chance(self.impairment.loss) {
                let delay = self.impairment.delay.saturating_sub(self.ahead[to]);
                let due = self.now + delay + self.rng.below(self.impairment.jitter + 1);
                self.in_flight.push(InFlight { due, to, bytes: bytes.to_vec() });
            }
        }
    }

    pub(crate) fn poll(&mut self, peer: usize) {
        let mut out = [0; MAX_DATAGRAM];
        while let Some(len) = self.links[peer].poll(self.clock(peer), &mut out) {
            self.send(peer, &out[..len]);
        }
    }

    /// One millisecond: what is due arrives, both peers do their part.
    pub(crate) fn step(&mut self) {
        self.now += 1_000;
        let due = self.in_flight.extract_if(.., |datagram| datagram.due <= self.now).collect::<Vec<_>>();
        for mut datagram in due {
            let peer = datagram.to;
            if self.off[peer] {
                continue;
            }
            let now = self.clock(peer);
            if let Ok(Some(Message::Flow(flow))) = self.links[peer].receive(now, &mut datagram.bytes) {
                self.flows[peer].push(flow);
            }
            self.poll(peer);
        }
        self.tick += 1;
        for peer in 0..2 {
            if self.off[peer] {
                continue;
            }
            // The two peers' packet periods do not coincide.
            if self.tick % 8 == 3 * peer as u32 && !self.quiet[peer] {
                let along = AxisFlow { position: 0.5, energy_sent: f64::from(self.tick), ..AxisFlow::default() };
                let flow = Flow { tick: self.tick, axes: [along], ..Flow::default() };
                let mut out = [0; MAX_DATAGRAM];
                if let Some(len) = self.links[peer].send(self.clock(peer), flow, &mut out) {
                    self.send(peer, &out[..len]);
                }
            }
            self.poll(peer);
            while let Some(event) = self.links[peer].take_event() {
                self.events[peer].push(event);
            }
            while let Some(notice) = self.links[peer].take_notice() {
                self.notices[peer].push(notice);
            }
        }
    }

    pub(crate) fn run(&mut self, us: u64) {
        let end = self.now + us;
        while self.now < end {
            self.step();
        }
    }

    /// Runs until `done`; how long that took, µs.
    pub(crate) fn run_until(&mut self, limit: u64, done: impl Fn(&Self) -> bool) -> Option<u64> {
        let start = self.now;
        while !done(self) {
            if self.now - start >= limit {
                return None;
            }
            self.step();
        }
        Some(self.now - start)
    }

    pub(crate) fn stages(&self) -> [Stage; 2] {
        [self.links[0].stage(), self.links[1].stage()]
    }

    /// Flow comes at both.
    pub(crate) fn is_engaged(&self) -> bool {
        self.links.iter().all(|link| link.stage() == Stage::Running)
    }
}

/// Everything a link holds, but for the number of datagrams it refused.
pub(crate) fn state(link: &Link) -> String {
    let text = format!("{link:?}");
    let at = text.rfind("refused: ").unwrap();
    text[..at].to_string()
}
