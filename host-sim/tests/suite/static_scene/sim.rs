//! Servers, visitors and a bad network between them, in simulated time, from one seed.

use std::collections::{BTreeMap, BTreeSet};

use haptic_core::num::Motion;
use haptic_protocol::key::Key;
use haptic_sim::network::link::{InFlight, Route};
use haptic_sim::network::rule::Direction;
use haptic_sim::scene::Scene;
use host_sim::shared::visit::host::Host;
use host_sim::shared::visit::visitor::{Party, Setup, Visitor};
use host_sim::shared::world::World;

/// Who sends or gets a datagram: a server, or a client by its line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum End {
    Server(u8),
    Client(u32),
}

fn entropy(seed: u64) -> impl FnMut() -> [u8; Key::LEN] + Send + 'static {
    let mut state = seed;
    move || {
        std::array::from_fn(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as u8
        })
    }
}

pub(crate) struct Sim {
    pub(crate) hosts: BTreeMap<u8, Host<u32>>,
    pub(crate) visitors: BTreeMap<u32, Visitor>,
    /// Servers that are switched off.
    pub(crate) gone: BTreeSet<u8>,
    pub(crate) tick: u64,
    ways: [Route; 2],
    in_flight: InFlight<(End, End, Vec<u8>)>,
}

impl Sim {
    /// A world without servers or visitors, over the scene's network (`network.…` overrides) with 8 ms one way.
    pub(crate) fn new(network: &[&str]) -> Self {
        let network: Vec<String> = network.iter().map(|key| format!("network.{key}")).collect();
        let scene = Scene::load(None, &network).expect("a good network");
        let ways = [Direction::OneToTwo, Direction::TwoToOne].map(|direction| Route::of_scene(&scene, direction, 0));
        let (hosts, visitors) = (BTreeMap::new(), BTreeMap::new());
        Self { hosts, visitors, gone: BTreeSet::new(), tick: 0, ways, in_flight: InFlight::default() }
    }

    pub(crate) fn now(&self) -> u64 {
        1_000 * self.tick
    }

    pub(crate) fn serve(&mut self, number: u8, world: World, region: Option<u8>) {
        let seed = 1_000 + u64::from(number) + self.tick;
        let host = Host::new(Key::new([7; 32]), number, 16, world, region, entropy(seed)).expect("a good world");
        self.hosts.insert(number, host);
    }

    pub(crate) fn visit(&mut self, line: u32, home: u8, radius_m: Option<f32>) {
        let reachable = self.hosts.keys().copied().collect();
        let setup = Setup { key: Key::new([7; 32]).line(line), line, home, reachable, radius_m };
        self.visitors.insert(line, Visitor::new(setup, entropy(u64::from(line) + 10 * self.tick)));
    }

    fn send(&mut self, from: End, to: End, bytes: &[u8]) {
        let way = usize::from(matches!(from, End::Server(_)));
        self.ways[way]
            .send(1_000_000 * self.tick, bytes, |due_ns, bytes| self.in_flight.put(due_ns, (from, to, bytes)));
    }

    /// One control period with each visitor's hand where `hands` says; the force on each.
    pub(crate) fn step(&mut self, hands: impl Fn(u32) -> [Motion<f64>; 2]) -> BTreeMap<u32, [f64; 2]> {
        let (now, gone) = (self.now(), self.gone.clone());
        let mut said: Vec<(End, End, Vec<u8>)> = vec![];
        while let Some((_, (from, to, mut bytes))) = self.in_flight.take(1_000 * now) {
            match (from, to) {
                (End::Client(line), End::Server(number)) if !gone.contains(&number) => {
                    let Some(host) = self.hosts.get_mut(&number) else { continue };
                    host.receive(now, line, &mut bytes, |to, answer| {
                        said.push((End::Server(number), End::Client(to), answer.to_vec()));
                    });
                }
                (_, End::Client(line)) => {
                    let Some(visitor) = self.visitors.get_mut(&line) else { continue };
                    let from = match from {
                        End::Server(number) => Party::Server(number),
                        End::Client(who) => Party::Client(who),
                    };
                    visitor.receive(now, from, &mut bytes, |to, answer| {
                        said.push((to_end(line), end(to), answer.to_vec()))
                    });
                }
                _ => {}
            }
        }
        let mut forces = BTreeMap::new();
        for (line, visitor) in &mut self.visitors {
            forces.insert(*line, visitor.step(hands(*line)));
            // Packet periods do not coincide.
            if (self.tick + 3 * u64::from(*line)).is_multiple_of(8) {
                visitor.exchange(now, |to, bytes| said.push((End::Client(*line), end(to), bytes.to_vec())));
            }
        }
        if self.tick.is_multiple_of(8) {
            for (number, host) in self.hosts.iter_mut().filter(|(number, _)| !gone.contains(number)) {
                host.tick(now, |to, bytes| said.push((End::Server(*number), End::Client(to), bytes.to_vec())));
            }
        }
        for (from, to, bytes) in said {
            self.send(from, to, &bytes);
        }
        self.tick += 1;
        forces
    }

    /// Runs with every hand at rest at `hand` until `done`; ms that took.
    pub(crate) fn until(&mut self, limit_ms: u64, hand: [f64; 2], done: impl Fn(&Self) -> bool) -> u64 {
        let start = self.tick;
        while !done(self) {
            assert!(self.tick - start < limit_ms, "not done after {limit_ms} ms");
            self.step(|_| hand.map(Motion::at));
        }
        self.tick - start
    }
}

fn to_end(line: u32) -> End {
    End::Client(line)
}

fn end(party: Party) -> End {
    match party {
        Party::Server(number) => End::Server(number),
        Party::Client(line) => End::Client(line),
    }
}
