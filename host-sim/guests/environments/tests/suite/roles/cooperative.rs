//! The dynamics engine between a server and its clients, over networks that lose, double, delay and reorder, with clocks
//! that run apart and clients that crash: never two engines, always one again within a stated time, no version moved twice.

use std::collections::BTreeMap;

use cohold_environments::roles::cooperative::{Body, Client, Lease, Message, Notice, Server};
use cohold_environments::roles::{Carried as _, Role};
use cohold_protocol::wire::{Event, PeerId};

use crate::random::Rng;

const LEASE_US: u32 = 200_000;
const CLIENTS: usize = 3;
/// Longest way of any message, µs.
const SLOWEST: u64 = 400_000;

/// A message on its way: when it is due, from, to (0 is the server), the client's incarnation at its start.
struct InFlight {
    due: u64,
    from: usize,
    to: usize,
    incarnation: u32,
    event: Event,
}

/// A client with its clock and its object.
struct Node {
    client: Client,
    /// How fast its clock runs, and what it shows at time 0.
    rate: f64,
    offset: f64,
    incarnation: u32,
    body: Body,
    dead_until: u64,
}

impl Node {
    fn now(&self, time: u64) -> u64 {
        (self.offset + self.rate * time as f64) as u64
    }
}

struct World {
    rng: Rng,
    loss: f64,
    slowest: u64,
    flight: Vec<InFlight>,
    server: Server,
    body: Body,
    nodes: Vec<Node>,
    /// Who moved the object under each version.
    movers: BTreeMap<u32, usize>,
    moved_at: u64,
    longest_still: u64,
    transfers: u32,
}

fn lease() -> Lease {
    Lease::new(LEASE_US).unwrap()
}

impl World {
    fn new(seed: u64) -> Self {
        let mut rng = Rng(seed);
        let loss = [0.0, 0.1, 0.3, 0.6][rng.below(4) as usize];
        let slowest = [0, 5_000, 80_000, SLOWEST][rng.below(4) as usize];
        let nodes = (0..CLIENTS).map(|_| Node {
            client: Client::new(PeerId(0), lease()),
            rate: 1.0 + (rng.below(20_001) as f64 - 10_000.0) * 1e-6,
            offset: rng.below(1 << 40) as f64,
            incarnation: 0,
            body: Body::default(),
            dead_until: 0,
        });
        let nodes = nodes.collect();
        Self {
            rng,
            loss,
            slowest,
            flight: Vec::new(),
            server: Server::new(lease()),
            body: Body::default(),
            nodes,
            movers: BTreeMap::new(),
            moved_at: 0,
            longest_still: 0,
            transfers: 0,
        }
    }

    fn send(&mut self, time: u64, from: usize, to: usize, message: &Message) {
        let incarnation = self.nodes[from.max(to) - 1].incarnation;
        for _ in 0..1 + u64::from(self.rng.chance(0.2)) {
            if !self.rng.chance(self.loss) {
                let due = time + self.rng.below(self.slowest + 1);
                let event = message.event(0).unwrap();
                self.flight.push(InFlight { due, from, to, incarnation, event });
            }
        }
    }

    fn deliver(&mut self, time: u64) {
        let (due, later): (Vec<_>, _) = std::mem::take(&mut self.flight).into_iter().partition(|m| m.due <= time);
        self.flight = later;
        for InFlight { from, to, incarnation, event, .. } in due {
            let node = from.max(to) - 1;
            // A session ends with the incarnation of either end.
            if self.nodes[node].incarnation != incarnation || self.nodes[node].dead_until > time {
                continue;
            }
            let (_, message) = Message::parse(&event).unwrap();
            if to == 0 {
                let mut said = Vec::new();
                self.server.moves(self.body);
                self.server.receive(time, PeerId(from as u8), &message, &mut |_, message| said.push(message));
                if let Some(body) = self.server.take_notice() {
                    self.body = body;
                    self.transfers += 1;
                }
                said.iter().for_each(|message| self.send(time, 0, from, message));
            } else {
                let node = &mut self.nodes[node];
                let now = node.now(time);
                node.client.receive(now, PeerId(0), &message, &mut |_, _| ());
                match node.client.take_notice() {
                    Some(Notice::Came(body)) => node.body = body,
                    Some(Notice::Recalled) => node.client.give_back(now, node.body),
                    None => {}
                }
            }
        }
    }

    /// One step of 2 ms: whoever has the engine moves the object; the users want it now and then, and crash.
    fn step(&mut self, time: u64, calm: bool) {
        self.deliver(time);
        for at in 0..CLIENTS {
            if self.nodes[at].dead_until > time {
                continue;
            }
            if !calm && self.rng.chance(1e-3) {
                let node = &mut self.nodes[at];
                node.client = Client::new(PeerId(0), lease());
                node.incarnation += 1;
                node.dead_until = time + self.rng.below(500_000);
                continue;
            }
            let now = self.nodes[at].now(time);
            if self.rng.chance(0.01) {
                self.nodes[at].client.ask(now);
            }
            if self.rng.chance(0.01) {
                let body = self.nodes[at].body;
                self.nodes[at].client.give_back(now, body);
            }
            let mut said = Vec::new();
            self.nodes[at].client.poll(now, &mut |_, message| said.push(message));
            said.iter().for_each(|message| self.send(time, at + 1, 0, message));
        }
        if self.rng.chance(0.005) {
            self.server.recall(time);
        }
        let mut said = Vec::new();
        self.server.poll(time, &mut |to: PeerId, message| said.push((to, message)));
        self.body = self.server.take_notice().unwrap_or(self.body);
        said.iter().for_each(|(to, message)| self.send(time, 0, usize::from(to.0), message));
        self.look(time);
    }

    fn look(&mut self, time: u64) {
        let mut movers = Vec::new();
        if self.server.has_engine() {
            movers.push((0, self.server.version()));
        }
        for (at, node) in self.nodes.iter().enumerate().filter(|(_, node)| node.dead_until <= time) {
            movers.extend(node.client.engine(node.now(time)).map(|version| (at + 1, version)));
        }
        assert!(movers.len() <= 1, "two engines at {time}: {movers:?}");
        let Some(&(who, version)) = movers.first() else {
            self.longest_still = self.longest_still.max(time - self.moved_at);
            return;
        };
        self.moved_at = time;
        assert_eq!(*self.movers.entry(version).or_insert(who), who, "version {version} was moved twice");
        assert!(self.movers.keys().all(|known| *known <= version), "an old engine moves the object");
        let body = if who == 0 { &mut self.body } else { &mut self.nodes[who - 1].body };
        body.axes[0][0] += 1.0;
        let body = *body;
        if who > 0 && !self.rng.chance(self.loss) {
            self.server.take_state(PeerId(who as u8), version, body);
        }
    }
}

/// The kind of campaign: ten thousand seeded runs of four seconds.
#[test]
fn never_two_engines_and_always_one_again() {
    // Lent to a client that nothing reaches in time: a lease until its last request that counts, or the way of its last
    // renewal, and a lease more.
    let bound = 2 * u64::from(LEASE_US) + SLOWEST + 10_000;
    let (mut transfers, mut versions) = (0, 0);
    for seed in 0..10_000 {
        let mut world = World::new(seed);
        for step in 0..500 {
            world.step(step * 2_000, false);
        }
        assert!(world.longest_still <= bound, "seed {seed}: {} us without an engine", world.longest_still);
        // When the network is well again and nobody crashes, the object moves within the bound, for good.
        world.loss = 0.0;
        world.slowest = world.slowest.min(20_000);
        (world.moved_at, world.longest_still) = (1_000_000, 0);
        for step in 500..900 {
            world.step(step * 2_000, true);
        }
        assert!(world.longest_still <= bound, "seed {seed}: {} us without an engine", world.longest_still);
        transfers += world.transfers;
        versions += world.movers.len();
    }
    // A campaign in which nothing moved would prove nothing.
    assert!(transfers > 10_000 && versions > 50_000, "{transfers} returns, {versions} versions");
}

/// Without faults nothing of what was done is lost: every step is in the object, and it never stands longer than one way.
#[test]
fn the_object_goes_on_from_where_it_was() {
    let mut world = World::new(1);
    (world.loss, world.slowest) = (0.0, 0);
    let mut steps = 0.0;
    for step in 0..5_000 {
        world.step(step * 2_000, true);
        steps += if world.moved_at == step * 2_000 { 1.0 } else { 0.0 };
        let newest = world.nodes.iter().map(|node| node.body.axes[0][0]).fold(world.body.axes[0][0], f64::max);
        assert_eq!(newest, steps, "at step {step}");
    }
    assert!(world.transfers > 10 && world.longest_still <= 4_000, "{} {}", world.transfers, world.longest_still);
}
