//! Two homes, their routers and a meeting place in virtual time: 1 ms a step, each way of a datagram takes its time, nothing is random but what a seed says.
//!
//! A router maps each inner address to one outer port (*kept*) or to another for each partner (*symmetric*), and lets in what comes from whom the
//! inner one has written to (RFC 4787: address- and port-dependent filtering).

use std::collections::{BTreeMap, HashMap, HashSet};
use std::net::SocketAddr;
use std::time::{Duration, Instant};

use haptic_meeting::Way;
use haptic_meeting::carrier::{Carrier, Config};
use haptic_meeting::place::Place;
use haptic_protocol::key::Key;
use haptic_protocol::wire::VERSION;

pub(crate) const MEET: &str = "203.0.113.1:4000";
/// One way between home and anywhere, ms.
const WAY_MS: u64 = 8;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Router {
    Kept,
    Symmetric,
}

/// A home: what its router remembers.
pub(crate) struct Home {
    pub(crate) carrier: Carrier,
    router: Router,
    pub(crate) inner: SocketAddr,
    pub(crate) outer: std::net::IpAddr,
    maps: HashMap<(SocketAddr, Option<SocketAddr>), u16>,
    lets_in: HashSet<(u16, SocketAddr)>,
    next: u16,
    /// Flow that came, by number: how often.
    pub(crate) came: BTreeMap<u64, u32>,
    /// The same in the order in which it came: when, its number, and how long it took, ms.
    pub(crate) took: Vec<(u64, u64, u64)>,
    pub(crate) sent: u64,
    pub(crate) ways: Vec<(u64, Way)>,
}

impl Home {
    fn out(&mut self, to: SocketAddr) -> SocketAddr {
        let map = (self.inner, (self.router == Router::Symmetric).then_some(to));
        let next = &mut self.next;
        let port = *self.maps.entry(map).or_insert_with(|| {
            *next += 1;
            *next
        });
        self.lets_in.insert((port, to));
        SocketAddr::new(self.outer, port)
    }

    /// Flow has come: the number of it, and how long it took.
    fn takes(&mut self, ms: u64, bytes: &[u8]) {
        let [number, sent_ms] = [8, 16].map(|at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()));
        *self.came.entry(number).or_default() += 1;
        self.took.push((ms, number, ms - sent_ms));
    }

    /// The router forgets, and gives other ports from now on.
    pub(crate) fn forgets(&mut self) {
        self.maps.clear();
        self.lets_in.clear();
    }
}

/// What is under way: when it comes, from, to, what.
type Datagram = (u64, SocketAddr, SocketAddr, Vec<u8>);

pub(crate) struct World {
    pub(crate) start: Instant,
    pub(crate) ms: u64,
    pub(crate) homes: [Home; 2],
    /// None while it is down.
    pub(crate) place: Option<Place>,
    under_way: Vec<Datagram>,
    /// The direct path is cut.
    pub(crate) cut: bool,
    /// Datagrams to addresses that nobody has, by address.
    pub(crate) nowhere: HashMap<SocketAddr, Vec<Vec<u8>>>,
    /// All that crossed the network.
    pub(crate) seen: Vec<Datagram>,
    pub(crate) keeps: bool,
    /// How much longer a datagram by the relay takes, ms.
    pub(crate) relay_ms: u64,
}

impl World {
    pub(crate) fn new(routers: [Router; 2]) -> Self {
        Self::of(routers, false)
    }

    pub(crate) fn of(routers: [Router; 2], relay_only: bool) -> Self {
        let (start, meet) = (Instant::now(), MEET.parse().unwrap());
        let home = |side: u8| {
            let inner: SocketAddr = "192.168.1.10:40000".parse().unwrap();
            let config = Config { key: Key::new([9; 32]), side, meet, bases: vec![inner], mapped: None, relay_only };
            let (maps, lets_in, came, took, ways) = Default::default();
            Home {
                carrier: Carrier::new(config, &Key::new([side + 1; 32]), start),
                router: routers[usize::from(side)],
                inner,
                outer: std::net::IpAddr::from([203, 0, 113, 11 + side]),
                maps,
                lets_in,
                next: 50_000,
                came,
                took,
                sent: 0,
                ways,
            }
        };
        let (under_way, nowhere, seen) = Default::default();
        let place = Some(Place::new(&Key::new([3; 32]), start));
        let homes = [home(0), home(1)];
        Self { start, ms: 0, homes, place, under_way, cut: false, nowhere, seen, keeps: false, relay_ms: 0 }
    }

    pub(crate) fn now(&self) -> Instant {
        self.start + Duration::from_millis(self.ms)
    }

    /// A datagram crosses the network.
    pub(crate) fn post(&mut self, from: SocketAddr, to: SocketAddr, bytes: &[u8]) {
        let relayed = if from == MEET.parse().unwrap() { self.relay_ms } else { 0 };
        let datagram = (self.ms + WAY_MS + relayed, from, to, bytes.to_vec());
        if self.keeps {
            self.seen.push(datagram.clone());
        }
        self.under_way.push(datagram);
    }

    fn leave(&mut self, side: usize, sent: Vec<(SocketAddr, Vec<u8>)>) {
        for (to, bytes) in sent {
            let from = self.homes[side].out(to);
            self.post(from, to, &bytes);
        }
    }

    /// A millisecond: what has come is heard, then each end says what is due and one datagram of flow.
    pub(crate) fn step(&mut self) {
        self.ms += 1;
        let (now, meet) = (self.now(), MEET.parse::<SocketAddr>().unwrap());
        let (come, wait) = std::mem::take(&mut self.under_way).into_iter().partition(|(at, ..)| *at <= self.ms);
        self.under_way = wait;
        for (_, from, to, bytes) in come as Vec<Datagram> {
            let mut sent = Vec::new();
            if to == meet {
                if let Some(place) = &mut self.place {
                    place.hear(now, from, &bytes, &mut |to, bytes| sent.push((to, bytes.to_vec())));
                }
                sent.into_iter().for_each(|(to, bytes)| self.post(meet, to, &bytes));
                continue;
            }
            let Some(side) = self.homes.iter().position(|home| home.outer == to.ip()) else {
                self.nowhere.entry(to).or_default().push(bytes);
                continue;
            };
            let home = &mut self.homes[side];
            if !home.lets_in.contains(&(to.port(), from)) || self.cut && from != meet {
                continue;
            }
            if home.carrier.hear(now, from, &bytes, &mut |to, bytes| sent.push((to, bytes.to_vec()))) {
                home.takes(self.ms, &bytes);
            }
            self.leave(side, sent);
        }
        for side in 0..2 {
            let (home, mut sent) = (&mut self.homes[side], Vec::new());
            while let Some(bytes) = home.carrier.release(now) {
                home.takes(self.ms, &bytes);
            }
            let mut send = |to, bytes: &[u8]| sent.push((to, bytes.to_vec()));
            home.carrier.poll(now, &mut send);
            if home.carrier.way() != Way::Nowhere {
                let mut flow = [0; 88];
                flow[..2].copy_from_slice(&[VERSION, 3]);
                flow[8..16].copy_from_slice(&home.sent.to_le_bytes());
                flow[16..24].copy_from_slice(&self.ms.to_le_bytes());
                home.carrier.send(now, &flow, &mut send);
                home.sent += 1;
            }
            while let Some(change) = home.carrier.take_change() {
                home.ways.push((self.ms, change.way));
            }
            self.leave(side, sent);
        }
    }

    pub(crate) fn run(&mut self, to_ms: u64) {
        while self.ms < to_ms {
            self.step();
        }
    }

    pub(crate) fn ways(&self) -> [Way; 2] {
        [0, 1].map(|side: usize| self.homes[side].carrier.way())
    }

    /// Of what the other end has sent, so many did not come; the last, which are under way, left out.
    pub(crate) fn lost(&self, side: usize) -> u64 {
        let under_way = WAY_MS * 2 + self.relay_ms + 2;
        let (came, sent) = (&self.homes[side].came, self.homes[1 - side].sent);
        (0..sent.saturating_sub(under_way)).filter(|number| !came.contains_key(number)).count() as u64
    }
}
