//! Servers, visitors and a bad network between them, in simulated time, from one seed.

use std::collections::BTreeMap;

use cohold_core::num::Motion;
use cohold_environments::world::World;
use cohold_environments::world::host::Host;
use cohold_environments::world::visitor::{Correspondent, Setup, Visitor};
use cohold_protocol::key::Key;
use cohold_sim::engine::{Actor, Engine, Out, Seat};
use cohold_sim::network::link::Route;
use cohold_sim::network::rule::Direction;
use cohold_sim::scene::Scene;

/// Seats: servers by number, then clients by line.
const SERVERS: usize = 8;
const CLIENTS: usize = 16;

fn seat(party: Correspondent) -> usize {
    match party {
        Correspondent::Server(number) => usize::from(number),
        Correspondent::Client(line) => SERVERS + line as usize,
    }
}

fn party(seat: usize) -> Correspondent {
    if seat < SERVERS { Correspondent::Server(seat as u8) } else { Correspondent::Client((seat - SERVERS) as u32) }
}

/// Who sits there.
enum End {
    Nobody,
    Server(Box<Host<usize>>),
    Client { visitor: Box<Visitor>, line: u32, hand: [Motion<f64>; 2], force_n: [f64; 2] },
}

impl Actor<usize> for End {
    type Packet = [u8];

    fn hear(&mut self, now_ns: u64, from: usize, datagram: &mut [u8], out: &mut Out<'_, usize, [u8]>) {
        let now = now_ns / 1_000;
        match self {
            Self::Nobody => {}
            Self::Server(host) => drop(host.receive(now, from, datagram, out)),
            Self::Client { visitor, .. } => {
                visitor.receive(now, party(from), datagram, |to, bytes| out(seat(to), bytes));
            }
        }
    }

    fn speak(&mut self, now_ns: u64, out: &mut Out<'_, usize, [u8]>) {
        if let Self::Client { visitor, line, hand, force_n } = self {
            *force_n = visitor.step(*hand);
            // Packet periods do not coincide.
            if (now_ns / 1_000_000 + 3 * u64::from(*line)).is_multiple_of(8) {
                visitor.exchange(now_ns / 1_000, |to, bytes| out(seat(to), bytes));
            }
        }
    }

    fn act(&mut self, now_ns: u64, out: &mut Out<'_, usize, [u8]>) {
        if let Self::Server(host) = self
            && (now_ns / 1_000_000).is_multiple_of(8)
        {
            host.tick(now_ns / 1_000, out);
        }
    }
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
    engine: Engine<End>,
}

impl Sim {
    /// A world without servers or visitors, over the scene's network (`network.…` overrides) with 8 ms one way.
    pub(crate) fn new(network: &[&str]) -> Self {
        let network: Vec<String> = network.iter().map(|key| format!("network.{key}")).collect();
        let scene = Scene::load(cohold_sim::Laws::built_in(), None, &network).expect("a good network");
        let seats = (0..SERVERS + CLIENTS).map(|_| Seat::new(End::Nobody)).collect();
        let route = |from: usize, to: usize| {
            let direction = if from < SERVERS { Direction::TwoToOne } else { Direction::OneToTwo };
            Route::of_scene(&scene, direction, (from * SERVERS + to) as u32)
        };
        Self { engine: Engine::new(1_000_000, seats, route) }
    }

    pub(crate) fn tick(&self) -> u64 {
        self.engine.tick()
    }

    pub(crate) fn serve(&mut self, number: u8, world: World, region: Option<u8>) {
        let seed = 1_000 + u64::from(number) + self.tick();
        let host = Host::new(Key::new([7; 32]), number, 16, world, region, entropy(seed)).expect("a good world");
        self.engine.seats[usize::from(number)] = Seat::new(End::Server(Box::new(host)));
    }

    /// Switches a server off.
    pub(crate) fn switch_off(&mut self, number: u8) {
        self.engine.seats[usize::from(number)].off = true;
    }

    pub(crate) fn visit(&mut self, line: u32, home: u8, radius_m: Option<f32>) {
        let servers = self.engine.seats.iter().zip(0..).filter(|(seat, _)| matches!(seat.actor, End::Server(_)));
        let reachable = servers.map(|(_, number)| number).collect();
        let setup = Setup { key: Key::new([7; 32]).line(line), line, home, reachable, radius_m };
        let visitor = Box::new(Visitor::new(setup, entropy(u64::from(line) + 10 * self.tick())));
        let client = End::Client { visitor, line, hand: [Motion::REST; 2], force_n: [0.0; 2] };
        self.engine.seats[seat(Correspondent::Client(line))] = Seat::new(client);
    }

    pub(crate) fn host(&mut self, number: u8) -> &mut Host<usize> {
        match &mut self.engine.seats[usize::from(number)].actor {
            End::Server(host) => host,
            _ => panic!("no server {number}"),
        }
    }

    pub(crate) fn visitor(&self, line: u32) -> &Visitor {
        match &self.engine.seats[seat(Correspondent::Client(line))].actor {
            End::Client { visitor, .. } => visitor,
            _ => panic!("no visitor {line}"),
        }
    }

    pub(crate) fn visitor_mut(&mut self, line: u32) -> &mut Visitor {
        match &mut self.engine.seats[seat(Correspondent::Client(line))].actor {
            End::Client { visitor, .. } => visitor,
            _ => panic!("no visitor {line}"),
        }
    }

    /// One control period with each visitor's hand where `hands` says; the force on each.
    pub(crate) fn step(&mut self, hands: impl Fn(u32) -> [Motion<f64>; 2]) -> BTreeMap<u32, [f64; 2]> {
        for seat in &mut self.engine.seats {
            if let End::Client { line, hand, .. } = &mut seat.actor {
                *hand = hands(*line);
            }
        }
        self.engine.step(&mut |_| ());
        let force = |seat: &Seat<End>| match &seat.actor {
            End::Client { line, force_n, .. } => Some((*line, *force_n)),
            _ => None,
        };
        self.engine.seats.iter().filter_map(force).collect()
    }

    /// Runs with every hand at rest at `hand` until `done`; ms that took.
    pub(crate) fn until(&mut self, limit_ms: u64, hand: [f64; 2], done: impl Fn(&Self) -> bool) -> u64 {
        let start = self.tick();
        while !done(self) {
            assert!(self.tick() - start < limit_ms, "not done after {limit_ms} ms");
            self.step(|_| hand.map(Motion::at));
        }
        self.tick() - start
    }
}
