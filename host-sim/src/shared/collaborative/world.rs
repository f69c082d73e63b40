//! One run: peers with clocks of their own, a bad network, crashes and partitions, all from one seed.
//!
//! True time is µs. The network between the peers is a [`Mesh`], so that what the scene files can do to packets is what
//! happens here. A peer's record is stored after every step, before what it said leaves: a crash comes between steps, and what it
//! had said may be lost with it. Messages cross as the bytes of their events.

use haptic_protocol::roles::collaborative::Value;
use haptic_protocol::wire::{Event, PeerId};

use super::history::History;
use super::{Mistake, Trial};
use haptic_sim::network::link::InFlight;
use haptic_sim::network::mesh::{Clock, Letter, Mesh};
use haptic_sim::network::rule::Jitter;
use haptic_sim::rng::Rng;
use haptic_sim::scene::Network;

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

/// A peer of either scheme as the world sees it.
pub trait Peer {
    /// Does what is to be done at `now` of its own clock, with a message if one has come.
    ///
    /// # Errors
    /// What the checker says.
    fn step(
        &mut self,
        now: u64,
        message: Option<(PeerId, &Event)>,
        history: &mut History,
        rng: &mut Rng,
    ) -> Result<(), String>;
    /// What it says.
    fn say(&mut self) -> Vec<(PeerId, Event)>;
    /// Whether it may edit.
    fn owns(&self, now: u64) -> bool;
    /// Starts anew, from its record unless that is lost, too.
    fn restart(&mut self, now: u64, forgets: bool, rng: &mut Rng);
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

struct World<P> {
    peers: Vec<P>,
    clocks: Vec<Clock>,
    /// Until when each peer is down, true µs.
    down_until: Vec<u64>,
    mesh: Mesh,
    /// Which ways are cut: from, to.
    cut: Vec<bool>,
    flying: InFlight<Letter>,
    rng: Rng,
    history: History,
    run: Run,
}

impl<P: Peer> World<P> {
    fn new(trial: &Trial, cast: Cast<P>) -> Self {
        let mut rng = Rng::new(trial.seed);
        let count = cast.peers.len();
        // Within what a lease allows; one of them beyond, if that is the mistake.
        let slow = 1 + rng.below(count as u64 - 1) as usize;
        let slow = (trial.mistake == Some(Mistake::SlowClock)).then_some(slow);
        let clocks = (0..count)
            .map(|at| Clock {
                start_us: rng.below(1 << 40),
                rate: if slow == Some(at) { 0.25 } else { 0.94 + rng.below(120_000) as f64 * 1e-6 },
            })
            .collect();
        let network = Network {
            loss: rng.below(40) as f64 * 0.01,
            duplicate: rng.below(30) as f64 * 0.01,
            jitter: Jitter::Uniform,
            jitter_s: rng.below(60) as f64 * 1e-3,
            reorder: rng.below(10) as f64 * 0.01,
            reorder_depth_packets: 1000,
            ..Network::default()
        };
        let mesh = Mesh::new(count, network, HELD_BACK_US as f64 * 1e-9, &mut rng);
        let wait_bound_us = (cast.wait_bound_us)(2 * DELAY_US);
        Self {
            peers: cast.peers,
            clocks,
            down_until: vec![0; count],
            mesh,
            cut: vec![false; count * count],
            flying: InFlight::default(),
            rng,
            history: History::default(),
            run: Run { wait_bound_us, ..Run::default() },
        }
    }

    /// A peer does what is to be done, and what it says goes out.
    fn step(&mut self, now: u64, at: usize, message: Option<(usize, Event)>) {
        let message = message.as_ref().map(|(from, event)| (PeerId(*from as u8), event));
        let clock = self.clocks[at].at(now);
        if let Err(what) = self.peers[at].step(clock, message, &mut self.history, &mut self.rng) {
            self.wrong(Trouble::LostUpdate, now, &what);
        }
        for (to, event) in self.peers[at].say() {
            self.send(now, at, usize::from(to.0), event);
        }
        if self.owns(now, at)
            && let Some(other) = (0..self.peers.len()).find(|other| *other != at && self.owns(now, *other))
        {
            self.wrong(Trouble::TwoOwners, now, &format!("peers {at} and {other} both own the object"));
        }
    }

    fn owns(&self, now: u64, at: usize) -> bool {
        self.down_until[at] <= now && self.peers[at].owns(self.clocks[at].at(now))
    }

    fn send(&mut self, now: u64, from: usize, to: usize, event: Event) {
        self.run.messages += 1;
        let delays_us =
            if now < TROUBLE_US { self.mesh.delays_us(from, to, now) } else { vec![self.rng.below(DELAY_US)] };
        if self.cut[from * self.peers.len() + to] || delays_us.is_empty() {
            self.run.lost += 1;
            return;
        }
        for delay_us in delays_us {
            self.flying.put(now + DELAY_US + delay_us, Letter { from, to, event });
        }
    }

    fn wrong(&mut self, trouble: Trouble, now: u64, what: &str) {
        if self.run.trouble.is_none() {
            self.run.trouble = Some((trouble, format!("{what}, {} ms into the run", now / 1000)));
        }
    }

    /// What has arrived by `now`.
    fn deliver(&mut self, now: u64) {
        while let Some((due, Letter { from, to, event })) = self.flying.take(now) {
            if self.down_until[to] > due {
                self.run.lost += 1;
            } else {
                self.step(due, to, Some((from, event)));
            }
        }
    }

    /// The network comes together, falls into two, or loses single ways between two peers, one direction each.
    fn fall_apart(&mut self) {
        let (count, kind) = (self.peers.len(), self.rng.below(4));
        let sides = self.rng.below(1 << count);
        for way in 0..count * count {
            let (from, to) = (way / count, way % count);
            self.cut[way] = match kind {
                0 | 1 => false,
                2 => (sides >> from ^ sides >> to) & 1 == 1,
                _ => self.rng.chance(0.4),
            };
        }
    }

    /// Somebody crashes, or the network falls apart or comes together, now and then.
    fn disturb(&mut self, now: u64, crashes: f64, partitions: f64) {
        if self.rng.chance(partitions) {
            self.fall_apart();
        }
        for at in 0..self.peers.len() {
            if self.down_until[at] <= now && self.rng.chance(crashes) {
                self.run.crashes += 1;
                self.down_until[at] = (now + 20_000 + self.rng.below(DOWN_US)).min(TROUBLE_US);
            }
        }
    }
}

/// One run to its end.
pub fn run<P: Peer>(trial: &Trial, cast: Cast<P>) -> Run {
    let mut world = World::new(trial, cast);
    let forgets = trial.mistake == Some(Mistake::Amnesia);
    let count = world.peers.len();
    let crashes = world.rng.below(100) as f64 * 3e-5;
    let partitions = world.rng.below(100) as f64 * 1e-4;
    let bound = world.run.wait_bound_us;
    let mut waits: Vec<Option<u64>> = vec![None; count];
    let mut before = vec![0; count];
    let mut now = 0;
    while world.run.trouble.is_none() {
        now += POLL_US;
        world.deliver(now);
        if now < TROUBLE_US {
            world.disturb(now, crashes, partitions);
        }
        for at in 0..count {
            let until = world.down_until[at];
            if until > now {
                continue;
            }
            if until > 0 {
                world.down_until[at] = 0;
                let clock = world.clocks[at].at(now);
                world.peers[at].restart(clock, forgets, &mut world.rng);
            }
            world.step(now, at, None);
        }
        if now == TROUBLE_US {
            world.cut.fill(false);
            for at in 0..count {
                let clock = world.clocks[at].at(now);
                before[at] = world.peers[at].counts().0;
                waits[at] = world.peers[at].insist(clock).then_some(0);
            }
        }
        if now > TROUBLE_US {
            for at in 0..count {
                if waits[at] == Some(0) && world.peers[at].counts().0 > before[at] {
                    waits[at] = Some(now - TROUBLE_US);
                    world.run.longest_wait_us = world.run.longest_wait_us.max(now - TROUBLE_US);
                }
            }
            let waiting = waits.iter().position(|wait| *wait == Some(0));
            // What was held back before the end of trouble still arrives after it.
            match waiting {
                Some(at) if now - TROUBLE_US > bound + HELD_BACK_US => {
                    world.wrong(Trouble::NoProgress, now, &format!("peer {at} has not published"));
                }
                // One more second for everybody to hear of the last one.
                None if now - TROUBLE_US > world.run.longest_wait_us.max(HELD_BACK_US) + 1_000_000 => break,
                _ => {}
            }
        }
    }
    for at in 0..count {
        let last = world.peers[at].value().map_or(Ok(()), |value| world.history.last(&value));
        if world.run.trouble.is_none()
            && let Err(what) = last
        {
            world.wrong(Trouble::LostUpdate, now, &format!("peer {at}: {what}"));
        }
        if !world.peers[at].is_settled() {
            world.wrong(Trouble::NoProgress, now, &format!("peer {at} wanted to leave and has not left"));
        }
        world.run.interrupted += world.peers[at].counts().1;
    }
    world.run.published = world.history.published();
    world.run
}
