//! Restarts: two nodes in virtual time over an impaired network, one or the other starting anew at random instants.
//!
//! A restart forgets everything but where the device is: session, object, engagement, counters. The one that stays has to
//! notice, let go, and begin again with a peer that counts from zero. Measured for every restart: how long until both are
//! engaged again with each other, the first forces of either, and the largest step of a motor force meanwhile.
//!
//! Time moves in control periods, both peers' in step, so that the instants of a restart against the other's packets are
//! whole periods; the phases of the two peers' packets change with every restart.

use haptic_core::safety::{Guard, Mode};
use haptic_protocol::key::Key;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use serde::Serialize;

use haptic_sim::network::link::{Link, Route};
use haptic_sim::network::rule::Direction;
use haptic_sim::node::Node;
use haptic_sim::plant::Plant;
use haptic_sim::scene::Scene;

/// Longest that two peers may take to engage, s.
pub const PATIENCE_S: f64 = 0.5;
/// Longest time from engaging to the next restart, packet periods: well before and well after the ladder is climbed.
const LONGEST_PEACE_PACKETS: u64 = 16;

/// What the restarts showed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// Restarts.
    pub restarts: u64,
    /// Restarts after which the peers were not engaged again within [`PATIENCE_S`].
    pub failed: u64,
    /// Restarts after which the one that stayed never let go.
    pub held_on: u64,
    /// Peers that stopped with a fault.
    pub faults: u64,
    /// Mean time from the restart until both are engaged, ms.
    pub mean_ms: f64,
    /// Longest time from a restart until both are engaged, ms.
    pub slowest_ms: f64,
    /// Largest motor force in the first tick after arming, N.
    pub arming_force_n: f64,
    /// Largest coordination force in the first tick of an engagement, N: the first step of the ladder.
    pub first_force_n: f64,
    /// Largest step of a motor force from tick to tick, N.
    pub largest_step_n: f64,
    /// What the scene allows of it, N.
    pub allowed_step_n: f64,
    /// Seed of the instants and of the peers' keys; the network has its own.
    pub seed: u64,
}

/// One peer between restarts.
struct Life {
    node: Node,
    engaged: bool,
    /// It was seen not engaged since the last restart of either.
    let_go: bool,
    armed: bool,
    force_n: f64,
}

impl Life {
    fn new(scene: &Scene, number: u8, device: Plant, random: &mut Xoshiro256PlusPlus) -> Result<Self, String> {
        let mut entropy = [0; Key::LEN];
        random.fill_bytes(&mut entropy);
        let node = Node::with_device(scene, number, Key::new([0x5a; Key::LEN]), entropy, device)?;
        Ok(Self { node, engaged: false, let_go: true, armed: false, force_n: 0.0 })
    }
}

/// Two nodes and the network between them.
struct World<'a> {
    scene: &'a Scene,
    random: Xoshiro256PlusPlus,
    lives: [Life; 2],
    /// From peer 1 to peer 2 and back.
    lines: [Link<[u8]>; 2],
    now_us: u64,
    period_us: u64,
    report: Report,
}

impl World<'_> {
    /// One control period of both.
    fn step(&mut self) {
        self.now_us += self.period_us;
        for (index, life) in self.lives.iter_mut().enumerate() {
            // Each peer's own line is the one that it sends by.
            let [outward, inward] = match &mut self.lines {
                [first, second] if index == 0 => [first, second],
                [first, second] => [second, first],
            };
            while let Some((_, mut datagram)) = inward.take(1_000 * self.now_us) {
                // What a network broke, or was sent to an earlier life, is refused.
                let _ = life.node.receive(self.now_us, &mut datagram);
            }
            let actuators = life.node.beat(self.now_us, |bytes| outward.send(1_000 * self.now_us, bytes));
            let engaged = life.node.is_engaged();
            if engaged && !life.engaged {
                let first = f64::from(life.node.observed().coordination_force).abs();
                self.report.first_force_n = self.report.first_force_n.max(first);
            }
            life.engaged = engaged;
            life.let_go |= !engaged;
            let force_n = f64::from(actuators.forces[0]);
            if !life.armed && actuators.enable {
                self.report.arming_force_n = self.report.arming_force_n.max(force_n.abs());
            }
            life.armed = actuators.enable;
            self.report.largest_step_n = self.report.largest_step_n.max((force_n - life.force_n).abs());
            life.force_n = force_n;
        }
    }

    /// Until both have let go and engaged anew; the time that took, s, if it was within the patience.
    fn meet(&mut self) -> Option<f64> {
        let start_us = self.now_us;
        loop {
            let spent_s = (self.now_us - start_us) as f64 * 1e-6;
            if self.lives.iter().all(|life| life.engaged && life.let_go) {
                return Some(spent_s);
            }
            if spent_s >= PATIENCE_S {
                return None;
            }
            self.step();
        }
    }

    /// Uniform in 0..=most, as nearly as a test needs.
    fn below(&mut self, most: u64) -> u64 {
        self.random.next_u64() % (most + 1)
    }
}

/// Restarts one peer or the other `count` times.
///
/// # Errors
/// A scene that is refused, or peers that do not even meet once.
pub fn run(scene: &Scene, count: u64, seed: u64) -> Result<Report, String> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let timing = &scene.peer.timing;
    let mut life = |number: u8| Life::new(scene, number, Plant::new(scene, usize::from(number) - 1), &mut random);
    let lives = [life(1)?, life(2)?];
    let allowed_step_n = Guard::<f64>::build(&scene.peer).max_step;
    let mut world = World {
        scene,
        random,
        lives,
        lines: [Direction::OneToTwo, Direction::TwoToOne].map(|way| Link::new(Route::of_scene(scene, way, 0))),
        now_us: 0,
        period_us: (1e6 * timing.control_period_s).round() as u64,
        report: Report { allowed_step_n, seed, ..Report::default() },
    };
    if world.meet().is_none() {
        return Err(format!("the two peers do not meet within {PATIENCE_S} s: is the network worse than that?"));
    }
    let mut sum_s = 0.0;
    for _ in 0..count {
        let peace = world.below(LONGEST_PEACE_PACKETS * u64::from(timing.ticks_per_packet));
        for _ in 0..peace {
            world.step();
        }
        let peer = usize::from(world.below(1) == 1);
        world.lives[1 - peer].let_go = false;
        let device = world.lives[peer].node.device();
        world.lives[peer] = Life::new(world.scene, peer as u8 + 1, device, &mut world.random)?;
        let met = world.meet();
        world.report.restarts += 1;
        world.report.failed += u64::from(met.is_none());
        world.report.held_on += u64::from(!world.lives[1 - peer].let_go);
        let met_s = met.unwrap_or(PATIENCE_S);
        sum_s += met_s;
        world.report.slowest_ms = world.report.slowest_ms.max(1e3 * met_s);
        let faulted = |life: &&Life| matches!(life.node.mode(), Mode::Faulted(_));
        world.report.faults += world.lives.iter().filter(faulted).count() as u64;
    }
    world.report.mean_ms = 1e3 * sum_s / count.max(1) as f64;
    Ok(world.report)
}
