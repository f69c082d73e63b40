//! The meeting place: rooms of two seats, told apart by numbers that only the two can make, and what one of the two sends passed on to the other.
//!
//! It reads nothing but the first byte of what it passes on. It learns two addresses, and how much flows between them.
//!
//! **Whose a seat is**: a room is named after the public keys of its two seats, and both ends have both secret keys. A seat is taken, and moved to
//! another address, only by a proof of its secret key that is good for the cookie of one address. So an onlooker of a join can neither take the
//! other seat nor move this one.
//!
//! **Bounds**: nothing is kept of an address before its cookie came back from there, and it is sent fewer bytes than it sent (76 for 90). There are
//! [`MOST_ROOMS`] rooms; an address has one seat, a host (of IPv6 a network of 64 bits) [`MOST_SEATS`]. A seat passes on [`RATE`] bytes each second, and [`BURST`] at once,
//! each datagram counting at least [`LEAST`]. A seat that has not joined for [`SILENCE`] is free. Hosts share 256 counters by chance, and of each 20 proofs are looked at each second.
//! What comes from who has no seat, has a first byte that is not relayed or is longer than [`LONGEST`] goes nowhere.
//!
//! **A restart** costs what is under way: seats are taken again as fast as the ends notice (50 ms after the relay falls silent).

use std::collections::HashMap;
use std::net::{IpAddr, SocketAddr};
use std::time::{Duration, Instant};

use cohold_protocol::key::Key;
use serde::Serialize;
use subtle::ConstantTimeEq;

pub use crate::allowance::{BURST, LEAST, RATE};

use crate::allowance::{Allowance, passes};
use crate::frame::{Frame, Join, LONGEST, Public, Welcome, address_bytes, pair, proof};
use crate::{Send, stun};

/// Rooms at a time.
pub const MOST_ROOMS: usize = 4096;
/// Seats of one host: a home, or a few behind one router of a provider.
pub const MOST_SEATS: u16 = 8;
/// Without a join for so long a seat is free.
pub const SILENCE: Duration = Duration::from_secs(30);
/// How long a cookie is the newest; it is good for as long again.
const COOKIE_S: u64 = 10;
/// Proofs each second, and at once, from hosts that share a counter: a proof takes about as long as ten datagrams, so all of them take at most half
/// of a core, and after a restart 4,096 rooms are full again within a second or two.
const PROOFS: [f64; 2] = [20.0, 40.0];
/// Between two looks for seats that are free again.
const SWEEP: Duration = Duration::from_secs(1);

/// A seat that is taken.
#[derive(Debug)]
struct Taken {
    address: SocketAddr,
    joined: Instant,
    /// What may be passed on yet.
    allowance: Allowance,
}

/// What a meeting place has done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Datagrams that were passed on.
    pub passed: u64,
    /// Bytes of these.
    pub bytes: u64,
    /// Datagrams beyond what a seat may send.
    pub over_rate: u64,
    /// Datagrams from who has no seat or nobody opposite, or of no kind that is passed on.
    pub strangers: u64,
    /// Joins that got no seat though their address was proved.
    pub refused: u64,
    /// Questions of STUN that were answered.
    pub stun: u64,
}

/// A meeting place.
#[derive(Debug)]
pub struct Place {
    /// Makes cookies.
    secret: Key,
    /// Its keys of X25519, against which seats are proved.
    keys: (Key, Public),
    start: Instant,
    swept: Instant,
    rooms: HashMap<[u8; 16], [Option<Taken>; 2]>,
    /// The room and the seat of an address.
    seats: HashMap<SocketAddr, ([u8; 16], usize)>,
    /// Seats of a host.
    hosts: HashMap<IpAddr, u16>,
    /// Proofs that may be looked at yet; hosts share them by chance.
    proofs: Vec<Allowance>,
    /// What it has done.
    pub counts: Counts,
}

/// Who counts as one: a home has a network of IPv6.
fn host(address: SocketAddr) -> IpAddr {
    match address.ip() {
        IpAddr::V6(ip) => IpAddr::V6((u128::from(ip) >> 64 << 64).into()),
        v4 => v4,
    }
}

impl Place {
    /// One where nobody is; `entropy` must be unforeseeable and another at every start.
    pub fn new(entropy: &Key, now: Instant) -> Self {
        let (rooms, seats, hosts) = Default::default();
        let secret = Key::new(entropy.derive("place").first());
        let (keys, proofs) = (pair(&secret), vec![Allowance::new(PROOFS[1], now); 256]);
        Self { secret, keys, start: now, swept: now, rooms, seats, hosts, proofs, counts: Counts::default() }
    }

    /// Rooms with somebody in them.
    pub fn rooms(&self) -> usize {
        self.rooms.len()
    }

    /// Takes a datagram.
    pub fn hear(&mut self, now: Instant, from: SocketAddr, datagram: &[u8], send: &mut Send<'_>) {
        let frame = Frame::of(datagram);
        if frame.is_relayed() {
            if let Some(to) = self.pass(now, from, datagram.len()) {
                send(to, datagram);
            }
        } else if let (Frame::Join, Some(join)) = (frame, Join::parse(datagram)) {
            self.sweep(now);
            send(from, &self.welcome(now, from, &join).emit());
        } else if let (Frame::Stun, Some(answer)) = (frame, stun::answer(from, datagram)) {
            self.counts.stun += 1;
            send(from, &answer);
        } else {
            self.counts.strangers += 1;
        }
    }

    fn cookie(&self, from: SocketAddr, period: u64) -> [u8; 16] {
        self.secret.derive("cookie").with(&address_bytes(from)).with(&period.to_le_bytes()).first()
    }

    fn welcome(&mut self, now: Instant, from: SocketAddr, join: &Join) -> Welcome {
        let period = now.saturating_duration_since(self.start).as_secs() / COOKIE_S;
        // Who sends a cookie back is where he says.
        let newest = self.cookie(from, period);
        let is = |cookie: [u8; 16]| bool::from(cookie.ct_eq(&join.cookie));
        let proved = is(newest) || period > 0 && is(self.cookie(from, period - 1));
        let seated = proved && self.take(now, from, join);
        self.counts.refused += u64::from(proved && !seated);
        let opposite =
            || self.rooms.get(&join.room()).is_some_and(|seats| seats[usize::from(join.side != 1)].is_some());
        let (cookie, place, nonce) = (newest, self.keys.1, join.nonce);
        Welcome { seated, other: seated && opposite(), refused: proved && !seated, cookie, place, nonce, seen: from }
    }

    /// Takes the seat, or moves it, for who has its secret key; who sits there needs no proof to stay.
    fn take(&mut self, now: Instant, from: SocketAddr, join: &Join) -> bool {
        let (room, side) = (join.room(), usize::from(join.side == 1));
        if self.seats.get(&from) != Some(&(room, side)) {
            let taken = self.rooms.get(&room).and_then(|seats| seats[side].as_ref());
            // Who moves within his host gives a seat back before he takes one.
            let leaves = taken.is_some_and(|taken| host(taken.address) == host(from)) || self.seats.contains_key(&from);
            let many = self.hosts.get(&host(from)).is_some_and(|seats| *seats >= MOST_SEATS + u16::from(leaves));
            let full = self.rooms.len() >= MOST_ROOMS && !self.rooms.contains_key(&room);
            if full || many || !self.is_own(now, from, join) {
                return false;
            }
            self.leave(from);
            let before = self.rooms.get_mut(&room).and_then(|seats| seats[side].take());
            let allowance = before.as_ref().map_or_else(|| Allowance::new(BURST, now), |before| before.allowance);
            if let Some(before) = before {
                self.forget(before.address);
            }
            self.rooms.entry(room).or_default()[side] = Some(Taken { address: from, joined: now, allowance });
            self.seats.insert(from, (room, side));
            *self.hosts.entry(host(from)).or_default() += 1;
        } else if let Some(taken) = self.rooms.get_mut(&room).and_then(|seats| seats[side].as_mut()) {
            taken.joined = now;
        }
        true
    }

    /// Whether a join shows that the seat is its own, as far as this host may ask by now.
    fn is_own(&mut self, now: Instant, from: SocketAddr, join: &Join) -> bool {
        let [at] = self.secret.derive("host").with(&address_bytes(SocketAddr::new(host(from), 0))).first();
        let looks = self.proofs[usize::from(at)].takes(now, 1.0, PROOFS);
        looks && bool::from(proof(&self.keys.0, &join.seat, &join.cookie).ct_eq(&join.proof))
    }

    /// An address has no seat any more.
    fn forget(&mut self, address: SocketAddr) -> Option<([u8; 16], usize)> {
        let seat = self.seats.remove(&address)?;
        if let Some(seats) = self.hosts.get_mut(&host(address)) {
            *seats -= 1;
            if *seats == 0 {
                self.hosts.remove(&host(address));
            }
        }
        Some(seat)
    }

    fn leave(&mut self, address: SocketAddr) {
        let Some((room, side)) = self.forget(address) else { return };
        if let Some(seats) = self.rooms.get_mut(&room) {
            seats[side] = None;
            if seats.iter().all(Option::is_none) {
                self.rooms.remove(&room);
            }
        }
    }

    /// Where a datagram of so many bytes is passed on to.
    fn pass(&mut self, now: Instant, from: SocketAddr, bytes: usize) -> Option<SocketAddr> {
        let seat = self.seats.get(&from).filter(|_| bytes <= LONGEST);
        let seats = seat.and_then(|(room, side)| Some((self.rooms.get_mut(room)?, *side)));
        let Some(([Some(first), Some(second)], side)) = seats else {
            self.counts.strangers += 1;
            return None;
        };
        let (own, to) = if side == 0 { (first, second.address) } else { (second, first.address) };
        if !passes(&mut own.allowance, now, bytes) {
            self.counts.over_rate += 1;
            return None;
        }
        self.counts.passed += 1;
        self.counts.bytes += bytes as u64;
        Some(to)
    }

    fn sweep(&mut self, now: Instant) {
        if now.saturating_duration_since(self.swept) < SWEEP {
            return;
        }
        self.swept = now;
        let seats = self.rooms.values().flatten().flatten();
        let silent = seats.filter(|seat| now.saturating_duration_since(seat.joined) > SILENCE).map(|seat| seat.address);
        for address in silent.collect::<Vec<_>>() {
            self.leave(address);
        }
    }
}
