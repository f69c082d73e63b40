//! One run: peers with clocks of their own, a bad network, crashes and partitions, all from one seed.
//!
//! Peers and network are the [`Engine`]'s, so that what the scene files can do to packets is what happens here. A peer's record
//! is stored in every turn, before what it said leaves: a crash comes between turns, and what it had said may be lost with it.
//! Messages cross as the wire has them.

use std::cell::RefCell;
use std::rc::Rc;

use haptic_protocol::roles::collaborative::Value;
use haptic_protocol::wire::Message;
use haptic_sim::engine::{Actor, Clock, Engine, Seat, Seen};
use haptic_sim::network::link::Route;
use haptic_sim::network::rule::{Direction, Jitter, SeededRule};
use haptic_sim::rng::Rng;
use haptic_sim::scene::Network;

use super::history::History;
use super::trial::{Mistake, Trial};

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

/// A peer of either scheme as the world sees it; times are of its own clock, µs.
pub trait Peer: Actor<usize, Packet = Message> {
    /// Whether it may edit.
    fn owns(&self, now: u64) -> bool;
    /// Starts anew, from its record unless that is lost, too.
    fn restart(&mut self, now: u64, forgets: bool);
    /// Everything is well from now on; whether this peer has a user who must get to publish.
    fn insist(&mut self, now: u64) -> bool;
    /// Publications so far, and rights to edit that ended before.
    fn counts(&self) -> (u64, u64);
    /// Whether it is where it wanted to be, in the end.
    fn is_settled(&self) -> bool;
    /// What the object is to this peer, if it follows it.
    fn value(&self) -> Option<Value>;
}

/// What went wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// Two peers may edit at one instant.
    TwoOwners,
    /// The history is not one branch.
    LostUpdate,
    /// Somebody waited longer than the protocol's bound.
    NoProgress,
}

/// What a run came to.
#[derive(Clone, Debug, Default)]
pub struct Run {
    /// The first thing that went wrong.
    pub trouble: Option<(Trouble, String)>,
    /// Updates that their authors were told are published.
    pub published: u64,
    /// Rights that ended before their owner had finished.
    pub interrupted: u64,
    /// Crashes.
    pub crashes: u64,
    /// Messages sent.
    pub messages: u64,
    /// Messages that never arrived.
    pub lost: u64,
    /// Longest wait for a publication after the trouble, µs.
    pub longest_wait_us: u64,
    /// The protocol's bound, µs.
    pub wait_bound_us: u64,
}

/// Peers, and how long a user may have to wait once all is well: a function of the one-way delay, µs.
pub struct Cast<P> {
    /// The peers, numbered from 0.
    pub peers: Vec<P>,
    /// The bound.
    pub wait_bound_us: Box<dyn Fn(u64) -> u64>,
}

impl Run {
    fn wrong(&mut self, trouble: Trouble, now_us: u64, what: &str) {
        self.trouble.get_or_insert_with(|| (trouble, format!("{what}, {} ms into the run", now_us / 1000)));
    }
}

/// The network in the time of trouble, or after it; `rng` gives every way a stream of its own.
fn rule(network: Network, rng: &mut Rng) -> SeededRule {
    let network = Network { seed: rng.below(1 << 32) as u32, ..network };
    SeededRule::new(network, Direction::OneToTwo, HELD_BACK_US as f64 * 1e-9)
}

/// The network comes together, falls into two, or loses single ways between two peers, one direction each.
fn fall_apart<P: Peer>(engine: &mut Engine<P>, rng: &mut Rng) {
    let (count, kind) = (engine.seats.len(), rng.below(4));
    let sides = rng.below(1 << count);
    for way in 0..count * count {
        let (from, to) = (way / count, way % count);
        engine.route(from, to).cut = match kind {
            0 | 1 => false,
            2 => (sides >> from ^ sides >> to) & 1 == 1,
            _ => rng.chance(0.4),
        };
    }
}

/// Whether a peer that is there may edit.
fn owns<P: Peer>(seat: &Seat<P>, now_ns: u64) -> bool {
    !seat.off && seat.actor.owns(seat.clock.at(now_ns) / 1_000)
}

/// One run to its end.
pub fn run<P: Peer>(trial: &Trial, history: &Rc<RefCell<History>>, cast: Cast<P>) -> Run {
    let mut rng = Rng::new(trial.seed);
    let count = cast.peers.len();
    // Within what a lease allows; one of them beyond, if that is the mistake.
    let slow = 1 + rng.below(count as u64 - 1) as usize;
    let slow = (trial.mistake == Some(Mistake::SlowClock)).then_some(slow);
    let seats = cast.peers.into_iter().enumerate().map(|(at, actor)| {
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
    let way = |_, _| Route::new(1_000 * DELAY_US).with_rule(rule(bad, &mut rng));
    let mut engine = Engine::new(1_000 * POLL_US, seats, way);
    let forgets = trial.mistake == Some(Mistake::Amnesia);
    let (crashes, partitions) = (rng.below(100) as f64 * 3e-5, rng.below(100) as f64 * 1e-4);
    let mut run = Run { wait_bound_us: (cast.wait_bound_us)(2 * DELAY_US), ..Run::default() };
    // Until when each peer is down; how long it waited for a publication; how many it had before.
    let (mut down_until, mut waits, mut before) = (vec![0; count], vec![None; count], vec![0; count]);
    while run.trouble.is_none() {
        let now_us = engine.now_ns() / 1_000;
        if now_us < TROUBLE_US && rng.chance(partitions) {
            fall_apart(&mut engine, &mut rng);
        }
        for (seat, until) in engine.seats.iter_mut().zip(&mut down_until) {
            if seat.off && *until <= now_us {
                seat.off = false;
                seat.actor.restart(seat.clock.at(1_000 * now_us) / 1_000, forgets);
            } else if !seat.off && now_us < TROUBLE_US && rng.chance(crashes) {
                run.crashes += 1;
                seat.off = true;
                *until = (now_us + 20_000 + rng.below(DOWN_US)).min(TROUBLE_US);
            }
        }
        engine.step(&mut |Seen { now_ns, seat, seats, .. }| {
            if owns(&seats[seat], now_ns)
                && let Some(other) = (0..count).find(|other| *other != seat && owns(&seats[*other], now_ns))
            {
                run.wrong(Trouble::TwoOwners, now_ns / 1_000, &format!("peers {seat} and {other} both own the object"));
            }
        });
        if let Some(what) = &history.borrow().wrong {
            run.wrong(Trouble::LostUpdate, now_us, what);
        }
        if now_us == TROUBLE_US {
            for way in 0..count * count {
                let route = engine.route(way / count, way % count);
                route.cut = false;
                route.rule = Some(Box::new(rule(good, &mut rng)));
            }
            for (seat, (wait, before)) in engine.seats.iter_mut().zip(waits.iter_mut().zip(&mut before)) {
                *before = seat.actor.counts().0;
                *wait = seat.actor.insist(seat.clock.at(1_000 * now_us) / 1_000).then_some(0);
            }
        }
        if now_us > TROUBLE_US {
            let since_us = now_us - TROUBLE_US;
            for (seat, (wait, before)) in engine.seats.iter().zip(waits.iter_mut().zip(&before)) {
                if *wait == Some(0) && seat.actor.counts().0 > *before {
                    *wait = Some(since_us);
                    run.longest_wait_us = run.longest_wait_us.max(since_us);
                }
            }
            // What was held back before the end of trouble still arrives after it.
            match waits.iter().position(|wait| *wait == Some(0)) {
                Some(at) if since_us > run.wait_bound_us + HELD_BACK_US => {
                    run.wrong(Trouble::NoProgress, now_us, &format!("peer {at} has not published"));
                }
                // One more second for everybody to hear of the last one.
                None if since_us > run.longest_wait_us.max(HELD_BACK_US) + 1_000_000 => break,
                _ => {}
            }
        }
    }
    let (now_us, mut history) = (engine.now_ns() / 1_000, history.borrow_mut());
    for (at, peer) in engine.seats.iter().map(|seat| &seat.actor).enumerate() {
        if let Some(value) = peer.value() {
            history.last(at, &value);
        }
        if !peer.is_settled() {
            run.wrong(Trouble::NoProgress, now_us, &format!("peer {at} wanted to leave and has not left"));
        }
        run.interrupted += peer.counts().1;
    }
    if let Some(what) = &history.wrong {
        run.wrong(Trouble::LostUpdate, now_us, what);
    }
    (run.messages, run.lost, run.published) = (engine.counts().taken, engine.counts().lost, history.published());
    run
}
