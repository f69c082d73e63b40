//! One run: peers with clocks of their own, a bad network, crashes and partitions, all from one seed.
//!
//! Peers and network are the [`Engine`]'s, so that what the scene files can do to packets is what happens here. A peer's record
//! is stored in every turn, before what it said leaves: a crash comes between turns, and what it had said may be lost with it.
//! Messages cross as the wire has them.

use std::{cell::RefCell, rc::Rc};

use cohold_protocol::wire::{Message, PeerId};
use cohold_sim::engine::{Actor, Clock, Engine, EngineView, Out, Seat};
use cohold_sim::network::rule::{Direction, Jitter, SeededRule};
use cohold_sim::{network::link::Route, rng::Rng, scene::Network};

use super::trial::{Mistake, Scheme, Trial, Verdict};
use super::{history::History, lock, ring, user::User};
use crate::{Crossing, said};
use crate::{roles::Carried, roles::collaborative::Value};

/// Number of the shared object.
const OBJECT: u16 = 7;
/// End of the time in which things go wrong, µs.
const TROUBLE_US: u64 = 4_000_000;
/// How often a peer looks at the time, µs.
const POLL_US: u64 = 4_000;
/// One-way delay when nothing is wrong: this and up to this much jitter, µs.
const DELAY_US: u64 = 5_000;
/// Longest delay of a message that is held back, µs: several leases.
const HELD_BACK_US: u64 = 1_200_000;
/// Longest time a peer is down, µs.
const DOWN_US: u64 = 1_500_000;

/// A peer of either scheme; times are of its own clock, µs.
#[expect(clippy::large_enum_variant, reason = "at most nine of them")]
pub(super) enum SchemePeer {
    Server(lock::Server),
    Client(lock::Client),
    Member(ring::Member),
}

impl Actor<usize> for SchemePeer {
    type Packet = Crossing;

    fn hear(&mut self, now_ns: u64, from: usize, Crossing(message): &mut Crossing, out: &mut Out<'_, usize, Crossing>) {
        self.step(now_ns / 1_000, Some((PeerId(from as u8), message)), out);
    }

    fn speak(&mut self, now_ns: u64, out: &mut Out<'_, usize, Crossing>) {
        self.step(now_ns / 1_000, None, out);
    }
}

/// What came, as a role reads it; outside: whether it can.
fn read<M: Carried>(came: Option<(PeerId, &mut Message)>) -> Option<Option<(PeerId, M)>> {
    let Some((from, message)) = came else { return Some(None) };
    let (object, message) = M::read(message)?;
    (object == OBJECT).then_some(Some((from, message)))
}

impl SchemePeer {
    fn step(&mut self, now: u64, came: Option<(PeerId, &mut Message)>, out: &mut Out<'_, usize, Crossing>) {
        match self {
            Self::Member(member) => _ = read(came).map(|came| member.step(now, came, &mut said(OBJECT, out))),
            Self::Server(server) => _ = read(came).map(|came| server.step(now, came, &mut said(OBJECT, out))),
            Self::Client(client) => _ = read(came).map(|came| client.step(now, came, &mut said(OBJECT, out))),
        }
    }

    /// Whether it may edit.
    fn owns(&self, now: u64) -> bool {
        match self {
            Self::Server(_) => false,
            Self::Client(client) => client.role.owns(now),
            Self::Member(member) => member.ring.owns(now),
        }
    }

    /// Starts anew, from its record unless that is lost, too.
    fn restart(&mut self, now: u64, forgets: bool) {
        match self {
            Self::Server(server) => server.restart(now, forgets),
            Self::Client(client) => client.restart(now),
            Self::Member(member) => member.restart(now, forgets),
        }
    }

    fn user(&self) -> Option<&User> {
        match self {
            Self::Server(_) => None,
            Self::Client(client) => Some(&client.user),
            Self::Member(member) => Some(&member.user),
        }
    }

    fn published(&self) -> u64 {
        self.user().map_or(0, |user| user.published)
    }

    /// Everything is well from now on; whether this peer has a user who must get to publish.
    fn insist(&mut self, now: u64) -> bool {
        match self {
            Self::Server(_) => return false,
            Self::Client(client) => client.user.insist(now),
            Self::Member(member) => {
                member.user.insist(now);
                member.stay(now);
            }
        }
        !self.leaves()
    }

    /// Whether it leaves for good.
    fn leaves(&self) -> bool {
        matches!(self, Self::Member(member) if member.for_good)
    }

    /// What the object is to this peer.
    fn value(&self) -> Value {
        match self {
            Self::Server(server) => server.role.copy().value,
            Self::Client(client) => client.role.copy().value,
            Self::Member(member) => member.ring.state().value,
        }
    }
}

/// A promise of the scheme that a run broke.
#[derive(Clone, Copy)]
enum Trouble {
    TwoOwners,
    LostUpdate,
    NoProgress,
}

impl Verdict {
    /// Keeps the first thing that went wrong.
    fn wrong(&mut self, seed: u64, trouble: Trouble, now_us: u64, what: &str) {
        if self.first_failure.is_none() {
            self.first_failure = Some((seed, format!("{what}, {} ms into the run", now_us / 1000)));
            *match trouble {
                Trouble::TwoOwners => &mut self.two_owners,
                Trouble::LostUpdate => &mut self.lost_update,
                Trouble::NoProgress => &mut self.no_progress,
            } += 1;
        }
    }
}

/// The network in the time of trouble, or after it; `rng` gives every way a stream of its own.
fn rule(network: Network, rng: &mut Rng) -> SeededRule {
    let network = Network { seed: rng.below(1 << 32) as u32, ..network };
    SeededRule::new(network, Direction::OneToTwo, HELD_BACK_US as f64 * 1e-9)
}

/// The network comes together, falls into two, or loses single ways between two peers, one direction each.
fn disconnect_some(engine: &mut Engine<SchemePeer>, rng: &mut Rng) {
    let (count, kind) = (engine.seats.len(), rng.below(4));
    let sides = rng.below(1 << count);
    for pair in 0..count * count {
        let (from, to) = (pair / count, pair % count);
        engine.route(from, to).cut = match kind {
            0 | 1 => false,
            2 => (sides >> from ^ sides >> to) & 1 == 1,
            _ => rng.chance(0.4),
        };
    }
}

/// Whether a peer that is there may edit.
fn owns(seat: &Seat<SchemePeer>, now_ns: u64) -> bool {
    !seat.off && seat.actor.owns(seat.clock.at(now_ns) / 1_000)
}

/// One run to its end.
pub(super) fn run(trial: &Trial) -> Verdict {
    let (mut rng, seed, history) = (Rng::new(trial.seed), trial.seed, Rc::<RefCell<History>>::default());
    let (peers, wait_bound_us): (Vec<SchemePeer>, u64) = match trial.scheme {
        Scheme::Lock => {
            let (server, clients) = lock::peers(trial, &history);
            let peers = std::iter::once(SchemePeer::Server(server)).chain(clients.into_iter().map(SchemePeer::Client));
            (peers.collect(), lock::wait_bound_us(trial.users, 2 * DELAY_US))
        }
        Scheme::Ring => {
            let peers = ring::peers(trial, &history).into_iter().map(SchemePeer::Member);
            (peers.collect(), ring::wait_bound_us(trial.users, 2 * DELAY_US))
        }
    };
    let count = peers.len();
    // Within what a lease allows; one of them beyond, if that is the mistake.
    let slow = 1 + rng.below(count as u64 - 1) as usize;
    let slow = (trial.mistake == Some(Mistake::SlowClock)).then_some(slow);
    let seats = peers.into_iter().enumerate().map(|(at, actor)| {
        let rate = if slow == Some(at) { 0.25 } else { 0.94 + rng.below(120_000) as f64 * 1e-6 };
        Seat { clock: Clock { start_ns: 1_000 * rng.below(1 << 40), rate }, ..Seat::new(actor) }
    });
    let seats = seats.collect();
    let bad = Network {
        loss: rng.below(40) as f64 * 0.01,
        duplicate: rng.below(30) as f64 * 0.01,
        jitter: Jitter::Uniform,
        jitter_s: rng.below(60) as f64 * 1e-3,
        reorder: rng.below(10) as f64 * 0.01,
        reorder_depth_packets: 1000,
        ..Network::default()
    };
    let good = Network { jitter: Jitter::Uniform, jitter_s: DELAY_US as f64 * 1e-6, ..Network::default() };
    let pair = |_, _| Route::new(1_000 * DELAY_US).with_rule(rule(bad, &mut rng));
    let mut engine = Engine::new(1_000 * POLL_US, seats, pair);
    let forgets = trial.mistake == Some(Mistake::Amnesia);
    let (crashes, partitions) = (rng.below(100) as f64 * 3e-5, rng.below(100) as f64 * 1e-4);
    let mut verdict = Verdict { runs: 1, wait_bound_ms: wait_bound_us as f64 * 1e-3, ..Verdict::default() };
    // Until when each peer is down; how long it waited for a publication; how many it had before.
    let (mut down_until, mut waits, mut before) = (vec![0; count], vec![None; count], vec![0; count]);
    let mut longest_wait_us = 0;
    while verdict.first_failure.is_none() {
        let now_us = engine.now_ns() / 1_000;
        if now_us < TROUBLE_US && rng.chance(partitions) {
            disconnect_some(&mut engine, &mut rng);
        }
        for (seat, until) in engine.seats.iter_mut().zip(&mut down_until) {
            if seat.off && *until <= now_us {
                seat.off = false;
                seat.actor.restart(seat.clock.at(1_000 * now_us) / 1_000, forgets);
            } else if !seat.off && now_us < TROUBLE_US && rng.chance(crashes) {
                verdict.crashes += 1;
                seat.off = true;
                *until = (now_us + 20_000 + rng.below(DOWN_US)).min(TROUBLE_US);
            }
        }
        engine.step(&mut |EngineView { now_ns, seat, seats, .. }| {
            if owns(&seats[seat], now_ns)
                && let Some(other) = (0..count).find(|other| *other != seat && owns(&seats[*other], now_ns))
            {
                let what = format!("peers {seat} and {other} both own the object");
                verdict.wrong(seed, Trouble::TwoOwners, now_ns / 1_000, &what);
            }
        });
        if let Some(what) = &history.borrow().wrong {
            verdict.wrong(seed, Trouble::LostUpdate, now_us, what);
        }
        if now_us == TROUBLE_US {
            for pair in 0..count * count {
                let route = engine.route(pair / count, pair % count);
                route.cut = false;
                route.rule = Some(Box::new(rule(good, &mut rng)));
            }
            for (seat, (wait, before)) in engine.seats.iter_mut().zip(waits.iter_mut().zip(&mut before)) {
                *before = seat.actor.published();
                *wait = seat.actor.insist(seat.clock.at(1_000 * now_us) / 1_000).then_some(0);
            }
        }
        if now_us > TROUBLE_US {
            let since_us = now_us - TROUBLE_US;
            for (seat, (wait, before)) in engine.seats.iter().zip(waits.iter_mut().zip(&before)) {
                if *wait == Some(0) && seat.actor.published() > *before {
                    *wait = Some(since_us);
                    longest_wait_us = longest_wait_us.max(since_us);
                }
            }
            // What was held back before the end of trouble still arrives after it.
            match waits.iter().position(|wait| *wait == Some(0)) {
                Some(at) if since_us > wait_bound_us + HELD_BACK_US => {
                    verdict.wrong(seed, Trouble::NoProgress, now_us, &format!("peer {at} has not published"));
                }
                // One more second for everybody to hear of the last one.
                None if since_us > longest_wait_us.max(HELD_BACK_US) + 1_000_000 => break,
                _ => {}
            }
        }
    }
    let (now_us, mut history) = (engine.now_ns() / 1_000, history.borrow_mut());
    for (at, peer) in engine.seats.iter().map(|seat| &seat.actor).enumerate() {
        match peer {
            SchemePeer::Member(member) if member.for_good && !member.ring.has_left() => {
                let what = format!("peer {at} wanted to leave and has not left");
                verdict.wrong(seed, Trouble::NoProgress, now_us, &what);
            }
            // Who has left does not follow any more.
            _ if peer.leaves() => {}
            _ => history.last(at, &peer.value()),
        }
        verdict.interrupted += peer.user().map_or(0, |user| user.interrupted);
    }
    if let Some(what) = &history.wrong {
        verdict.wrong(seed, Trouble::LostUpdate, now_us, what);
    }
    verdict.longest_wait_ms = longest_wait_us as f64 * 1e-3;
    verdict.published = history.published.len() as u64;
    (verdict.messages, verdict.lost) = (engine.counts().taken, engine.counts().lost);
    verdict
}
