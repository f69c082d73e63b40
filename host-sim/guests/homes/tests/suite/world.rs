//! Two homes, their routers and a meeting place in virtual time: 1 ms a step, each way of a datagram takes its time, nothing is random but what a seed says.
//!
//! A router maps each inner address to one outer port (*kept*) or to another for each partner (*symmetric*), and lets in what comes from whom the
//! inner one has written to (RFC 4787: address- and port-dependent filtering). An *open* one keeps a stranger's datagram as a flow of its own, and then sends
//! to that stranger from another port. IPv6 has no ports to map: what comes from whom was written to is let in. Both homes may be behind one router,
//! which takes what one of them sends to its outer address back in (*hairpin*) or does not; it keeps them apart inside.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::net::{IpAddr, SocketAddr};
use std::time::{Duration, Instant};

use cohold_homes::Way;
use cohold_homes::carrier::{Carrier, Config};
use cohold_homes::place::Place;
use cohold_protocol::key::Key;
use cohold_protocol::wire::VERSION;

pub(crate) const MEET: &str = "203.0.113.1:4000";
/// One way between home and anywhere, ms.
const WAY_MS: u64 = 8;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Router {
    Kept,
    Symmetric,
    Open,
}

/// A home: what its router remembers.
pub(crate) struct Home {
    pub(crate) carrier: Carrier,
    router: Router,
    pub(crate) inner: SocketAddr,
    pub(crate) outer: IpAddr,
    /// Its address of IPv6, if it has one.
    v6: Option<SocketAddr>,
    maps: HashMap<(SocketAddr, Option<SocketAddr>), u16>,
    /// Whom each outer address lets in.
    lets_in: HashSet<(SocketAddr, SocketAddr)>,
    /// What strangers sent to which port, which the router takes for flows of its own.
    claimed: HashSet<(u16, SocketAddr)>,
    /// A port that lets everybody in, as the router was told to.
    pub(crate) passes: Option<u16>,
    next: u16,
    /// Flow that came, by number: how often.
    pub(crate) came: BTreeMap<u64, u32>,
    /// The same in the order in which it came: when, its number, and how long it took, ms.
    pub(crate) took: Vec<(u64, u64, u64)>,
    pub(crate) sent: u64,
    pub(crate) ways: Vec<(u64, Way)>,
}

impl Home {
    fn out(&mut self, to: SocketAddr) -> Option<SocketAddr> {
        let from = if to.is_ipv6() { self.v6? } else { SocketAddr::new(self.outer, self.port(to)) };
        self.lets_in.insert((from, to));
        Some(from)
    }

    fn port(&mut self, to: SocketAddr) -> u16 {
        let next = &mut self.next;
        let mut fresh = || {
            *next += 1;
            *next
        };
        let own =
            *self.maps.entry((self.inner, (self.router == Router::Symmetric).then_some(to))).or_insert_with(&mut fresh);
        let claimed = self.router == Router::Open && self.claimed.contains(&(own, to));
        if claimed { *self.maps.entry((self.inner, Some(to))).or_insert_with(fresh) } else { own }
    }

    /// Whether a datagram comes to this home.
    fn takes_from(&mut self, from: SocketAddr, to: SocketAddr) -> bool {
        let passed = to.is_ipv4() && self.passes == Some(to.port());
        if passed {
            // What is answered to who came by there goes out by there.
            self.maps.insert((self.inner, Some(from)), to.port());
        }
        let lets_in = passed || self.lets_in.contains(&(to, from));
        if !lets_in && self.router == Router::Open {
            self.claimed.insert((to.port(), from));
        }
        lets_in
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
        self.claimed.clear();
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
    /// Both homes are behind one router, and whether it takes back in what one of them sends to the other's outer address.
    one_router: Option<bool>,
}

impl World {
    pub(crate) fn new(routers: [Router; 2]) -> Self {
        Self::of(routers, false)
    }

    pub(crate) fn of(routers: [Router; 2], relay_only: bool) -> Self {
        Self::with(routers, relay_only, [false; 2], None)
    }

    /// Homes of which some have IPv6 as well, behind one router or two.
    pub(crate) fn with(routers: [Router; 2], relay_only: bool, v6: [bool; 2], one_router: Option<bool>) -> Self {
        let (start, meet) = (Instant::now(), MEET.parse().unwrap());
        let home = |side: u8| {
            let (number, shared) = (usize::from(side), u8::from(one_router.is_none()));
            // Two homes have the same private addresses; behind one router they have not.
            let inner = SocketAddr::from(([192, 168, 1, 10 + side * (1 - shared)], 40_000));
            let v6: Option<SocketAddr> = v6[number].then(|| format!("[2001:db8:{side}::10]:40000").parse().unwrap());
            let bases = [inner].into_iter().chain(v6).collect();
            let config = Config { key: Key::new([9; 32]), side, meet, bases, mapped: None, relay_only };
            let (maps, lets_in, claimed, came, took, ways, passes) = Default::default();
            Home {
                carrier: Carrier::new(config, &Key::new([side + 1; 32]), start),
                router: routers[number],
                inner,
                outer: IpAddr::from([203, 0, 113, 11 + side * shared]),
                v6,
                maps,
                lets_in,
                claimed,
                passes,
                next: 50_000 + 1000 * u16::from(side) * u16::from(1 - shared),
                came,
                took,
                sent: 0,
                ways,
            }
        };
        let (under_way, nowhere, seen) = Default::default();
        let place = Some(Place::new(&Key::new([3; 32]), start));
        let homes = [home(0), home(1)];
        Self { start, ms: 0, homes, place, under_way, cut: false, nowhere, seen, keeps: false, relay_ms: 0, one_router }
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
            // From a home without IPv6 nothing goes there.
            if let Some(from) = self.homes[side].out(to) {
                self.post(from, to, &bytes);
            }
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
            // Behind one router the port says whose it is.
            let is_at = |home: &Home| match self.one_router {
                Some(_) => home.outer == to.ip() && home.lets_in.iter().any(|(own, _)| *own == to),
                None => home.outer == to.ip() || home.v6 == Some(to),
            };
            let Some(side) = self.homes.iter().position(is_at) else {
                self.nowhere.entry(to).or_default().push(bytes);
                continue;
            };
            let home = &mut self.homes[side];
            let turned_back = self.one_router == Some(false) && from.ip() == to.ip();
            if turned_back || self.cut && from != meet || !home.takes_from(from, to) {
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
