//! The dynamics engine between a server and two clients, on a network that the script commands, with clocks as far apart as is
//! allowed and clients that crash. Never two engines; a version is moved by one of them only, and never after a later one;
//! the object goes on from where it was announced to be; and in the end the server has the engine again in time.

use cohold_environments::roles::Role;
use cohold_environments::roles::collaborative::Lease;
use cohold_environments::roles::cooperative::{Body, Client, Message, Notice, Server};
use cohold_protocol::wire::PeerId;

use super::net::{Clock, Net};
use super::script::Script;

const CLIENTS: usize = 2;
const LEASE_US: u32 = 100_000;

struct World {
    time_us: u64,
    /// With the client's life at the start of the way: a session ends with it.
    net: Net<(u32, Message)>,
    server: Server,
    body: Body,
    clients: [(Client, Body); CLIENTS],
    clocks: [Clock; CLIENTS + 1],
    lives: [u32; CLIENTS],
    /// The newest version that anybody moved, who that was, and every body that was ever announced.
    newest: (u32, usize),
    moved: f64,
}

impl World {
    fn new(lease: Lease) -> Self {
        let drift = i64::from(Lease::MAX_DRIFT_PPM);
        let clock = |number: usize| Clock { start_us: 1 << (number * 15), fast_ppm: [drift, -drift, drift][number] };
        Self {
            time_us: 0,
            net: Net::new(),
            server: Server::new(lease),
            body: Body::default(),
            clients: std::array::from_fn(|_| (Client::new(PeerId(0), lease), Body::default())),
            clocks: std::array::from_fn(clock),
            lives: [0; CLIENTS],
            newest: (0, 0),
            moved: 0.0,
        }
    }

    fn now(&self, peer: usize) -> u64 {
        self.clocks[peer].at(self.time_us)
    }

    fn send(&mut self, from: usize, to: usize, message: Message) {
        self.net.send(from, to, (self.lives[from.max(to) - 1], message));
    }

    fn poll(&mut self, peer: usize) {
        let now = self.now(peer);
        if let Some(at) = peer.checked_sub(1) {
            let mut said = Vec::new();
            self.clients[at].0.poll(now, &mut |_, message| said.push(message));
            said.into_iter().for_each(|message| self.send(peer, 0, message));
            return;
        }
        let mut said = Vec::new();
        self.server.poll(now, &mut |to: PeerId, message| said.push((to, message)));
        let came = self.server.take_notice();
        self.came(0, came);
        said.into_iter().for_each(|(to, message)| self.send(0, usize::from(to.0), message));
    }

    fn receive(&mut self, (from, to, (life, message)): (usize, usize, (u32, Message))) {
        if self.lives[from.max(to) - 1] != life {
            return;
        }
        let now = self.now(to);
        match to.checked_sub(1) {
            None => {
                let mut said = Vec::new();
                self.server.moves(self.body);
                self.server.receive(now, PeerId(from as u8), &message, &mut |_, message| said.push(message));
                let came = self.server.take_notice();
                self.came(0, came);
                said.into_iter().for_each(|message| self.send(0, from, message));
            }
            Some(at) => {
                self.clients[at].0.receive(now, PeerId(0), &message, &mut |_, _| ());
                match self.clients[at].0.take_notice() {
                    Some(Notice::Came(body)) => self.came(to, Some(body)),
                    Some(Notice::Recalled) => self.give_back(at),
                    None => {}
                }
            }
        }
    }

    /// The engine is at `peer`, and the object there.
    fn came(&mut self, peer: usize, body: Option<Body>) {
        let Some(body) = body else { return };
        // Somewhere on its way, and nowhere that nobody ever moved it to.
        assert!((0.0..=self.moved).contains(&body.axes[0][0]) && body.axes[0][0].fract() == 0.0, "{body:?}");
        *(if peer == 0 { &mut self.body } else { &mut self.clients[peer - 1].1 }) = body;
    }

    /// A millisecond in which everything arrives and everybody looks at the time.
    fn calm(&mut self) {
        self.time_us += 1_000;
        for message in self.net.take_all() {
            self.receive(message);
        }
        (0..=CLIENTS).for_each(|peer| self.poll(peer));
        self.look(true);
    }

    fn give_back(&mut self, at: usize) {
        let (now, body) = (self.now(at + 1), self.clients[at].1);
        self.clients[at].0.give_back(now, body);
    }

    /// What must always be true. Whoever has the engine moves the object; the server hears of it, or not.
    fn look(&mut self, told: bool) {
        let here = self.server.has_engine().then(|| (0, self.server.version()));
        let there = self
            .clients
            .iter()
            .zip(1..)
            .filter_map(|((client, _), peer)| Some((peer, client.engine(self.clocks[peer].at(self.time_us))?)));
        let movers: Vec<(usize, u32)> = here.into_iter().chain(there).collect();
        assert!(movers.len() <= 1, "two engines at {}: {movers:?}", self.time_us);
        let Some(&(who, version)) = movers.first() else { return };
        assert!(
            version > self.newest.0 || (version, who) == self.newest,
            "{who} moves {version} after {:?}",
            self.newest
        );
        self.newest = (version, who);
        self.moved += 1.0;
        let body = if who == 0 { &mut self.body } else { &mut self.clients[who - 1].1 };
        body.axes[0][0] += 1.0;
        if who > 0 && told {
            self.server.take_state(PeerId(who as u8), version, *body);
        }
    }
}

/// Runs one fuzz input through an engine's server and two clients.
pub(super) fn run(bytes: &[u8]) {
    let lease = Lease::new(LEASE_US).expect("an allowed lease");
    let (mut world, mut script) = (World::new(lease), Script(bytes));
    while script.goes_on() {
        let (call, peer) = (script.byte(), script.below(CLIENTS + 1));
        let at = peer.saturating_sub(1);
        let now = world.now(at + 1);
        match call % 16 {
            0 | 1 => world.time_us += script.time_us(),
            2 | 3 => (0..script.below(16)).for_each(|_| world.calm()),
            4 | 5 => world.poll(peer),
            6..=9 => {
                if let Some(message) = world.net.deliver(&mut script) {
                    world.receive(message);
                }
            }
            10 if call < 128 => world.net.lose(&mut script),
            10 => world.net.cut_or_mend(peer),
            11 | 12 => world.clients[at].0.ask(now),
            13 => world.give_back(at),
            14 => {
                let now = world.now(0);
                world.server.recall(now);
            }
            _ => {
                world.lives[at] += 1;
                world.clients[at] = (Client::new(PeerId(0), lease), Body::default());
            }
        }
        world.look(call & 16 == 0);
    }
    world.net.cut = None;
    // Peace: everything arrives within a millisecond, nobody asks, and the server wants the engine back.
    let end = world.time_us + 2 * u64::from(LEASE_US) + 10_000;
    while !world.server.has_engine() {
        assert!(world.time_us < end, "the engine does not come back");
        let now = world.now(0);
        world.server.recall(now);
        (0..CLIENTS).for_each(|at| world.give_back(at));
        world.calm();
    }
}
