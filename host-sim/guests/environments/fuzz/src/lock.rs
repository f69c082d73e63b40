//! A lock's server and three clients on a network that the script commands, with clocks as far apart as is allowed, users that
//! come and go, clients and servers that crash. Never two owners; what is published was made by the owner, from what was
//! published before; everybody is told the truth about it; and in the end whoever asks is granted in time.

use std::collections::HashMap;

use cohold_environments::roles::collaborative::Lease;
use cohold_environments::roles::collaborative::lock::{Client, Message, Notice, Phase, Server, wait_bound_us};
use cohold_environments::roles::{Outbox, Role};
use cohold_protocol::wire::PeerId;

use super::net::{Clock, Net};
use super::script::Script;

const CLIENTS: usize = 3;
const LEASE_US: u32 = 100_000;
/// The server is 0 on the network, clients are their numbers.
const SERVER: PeerId = PeerId(0);

struct World {
    time_us: u64,
    net: Net<Message>,
    out: Outbox<Message, 64>,
    server: Server<CLIENTS>,
    clients: [Client; CLIENTS],
    clocks: [Clock; CLIENTS + 1],
    lives: u32,
    /// Values that were released: which version they were made from, under which grant.
    released: HashMap<u32, (u32, [u8; 24])>,
    /// Versions that the server took.
    taken: Vec<u32>,
    /// Version that each owner began with.
    base: [u32; CLIENTS],
    /// Grants that each client was notified of.
    granted: [u32; CLIENTS],
}

impl World {
    fn new() -> Self {
        let lease = Lease::new(LEASE_US).expect("an allowed lease");
        let drift = i64::from(Lease::MAX_DRIFT_PPM);
        let clock = |number: usize| Clock {
            start_us: 1 << (number * 15),
            fast_ppm: if number == 0 { drift } else { [-drift, drift, 0][number % 3] },
        };
        Self {
            time_us: 0,
            net: Net::new(),
            out: Outbox::new(),
            server: Server::new(lease, [0; 24]),
            clients: [1, 2, 3].map(|life| Client::new(SERVER, lease, life, [0; 24])),
            clocks: std::array::from_fn(clock),
            lives: 3,
            released: HashMap::new(),
            taken: vec![0],
            base: [0; CLIENTS],
            granted: [0; CLIENTS],
        }
    }

    fn now(&self, peer: usize) -> u64 {
        self.clocks[peer].at(self.time_us)
    }

    fn poll(&mut self, peer: usize) {
        let now = self.now(peer);
        match peer.checked_sub(1) {
            None => self.server.poll(now, &mut self.out),
            Some(client) => self.clients[client].poll(now, &mut self.out),
        }
        self.net.post(peer, &mut self.out);
    }

    fn receive(&mut self, (from, to, message): (usize, usize, Message)) {
        let (now, from) = (self.now(to), PeerId(from as u8));
        match to.checked_sub(1) {
            None => self.server.receive(now, from, &message, &mut self.out),
            Some(client) => self.clients[client].receive(now, from, &message, &mut self.out),
        }
        self.net.post(to, &mut self.out);
        self.look();
    }

    /// A millisecond in which everything arrives and everybody looks at the time.
    fn calm(&mut self) {
        self.time_us += 1_000;
        for message in self.net.take_all() {
            self.receive(message);
        }
        (0..=CLIENTS).for_each(|peer| self.poll(peer));
        self.look();
    }

    /// The user of `client` has finished, and has changed the object or not.
    fn release(&mut self, client: usize, changed: bool) {
        let Phase::Owner { fence, .. } = self.clients[client].phase() else { return };
        let mut value = [client as u8; 24];
        value[..4].copy_from_slice(&fence.to_le_bytes());
        let now = self.now(client + 1);
        if self.clients[client].release(now, changed.then_some(value), &mut self.out).is_ok() && changed {
            self.released.insert(fence, (self.base[client], value));
        }
        self.net.post(client + 1, &mut self.out);
    }

    /// What must always be true.
    fn look(&mut self) {
        let owners = (0..CLIENTS).filter(|client| self.clients[*client].owns(self.now(client + 1)));
        assert!(owners.count() <= 1, "two owners at {}", self.time_us);
        let (copy, before) = (*self.server.copy(), *self.taken.last().expect("there is a first"));
        if copy.version != before {
            assert!(copy.version > before, "version {} after {before}", copy.version);
            assert_eq!(self.released.get(&copy.version), Some(&(before, copy.value)), "an update is lost");
            self.taken.push(copy.version);
        }
        for (at, client) in self.clients.iter_mut().enumerate() {
            while let Some(notice) = client.take_notice() {
                match notice {
                    Notice::Granted => {
                        self.base[at] = client.copy().version;
                        self.granted[at] += 1;
                    }
                    Notice::Published(version) => assert!(self.taken.contains(&version), "{version} was not taken"),
                    Notice::TooLate(fence) => assert!(!self.taken.contains(&fence), "{fence} was taken"),
                    Notice::Changed(version) => assert!(self.taken.contains(&version)),
                    Notice::Expired => {}
                }
            }
        }
    }
}

/// Runs one fuzz input through a lock's server and three clients.
pub(super) fn run(bytes: &[u8]) {
    let lease = Lease::new(LEASE_US).expect("an allowed lease");
    let (mut world, mut script) = (World::new(), Script(bytes));
    while script.goes_on() {
        let (call, peer) = (script.byte(), script.below(CLIENTS + 1));
        let client = peer.saturating_sub(1);
        let now = world.now(client + 1);
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
            11 | 12 => world.clients[client].ask(now),
            13 => world.release(client, call & 16 == 0),
            14 => {
                world.clients[client].withdraw(&mut world.out);
                world.net.post(client + 1, &mut world.out);
            }
            _ if call < 128 => {
                world.lives += 1;
                world.clients[client] = Client::new(SERVER, lease, world.lives, [0; 24]);
            }
            _ => world.server = Server::restore(lease, world.now(0), world.server.record().clone()),
        }
        world.look();
    }
    world.net.cut = None;
    // Peace: everything arrives within a millisecond, and who owns the object lets go of it at once.
    world.clients.iter_mut().for_each(|client| *client = Client::new(SERVER, lease, world.lives + 1, [0; 24]));
    let bound = wait_bound_us(lease, CLIENTS as u64, 1_000, 1_000);
    let (end, before) = (world.time_us + bound + bound / 10, world.granted);
    while world.granted[0] == before[0] {
        assert!(world.time_us < end, "client 1 is not granted within {bound} us");
        for client in 0..CLIENTS {
            world.release(client, true);
            let now = world.now(client + 1);
            world.clients[client].ask(now);
        }
        world.calm();
    }
}
