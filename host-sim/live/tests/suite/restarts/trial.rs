//! Restarts: two nodes in virtual time over an impaired network, one or the other starting anew at random instants.
//!
//! A restart forgets everything but where the device is: session, object, engagement, counters. The one that stays has to
//! notice, let go, and begin again with a peer that counts from zero. Measured for every restart: how long until both are
//! engaged again with each other, the first forces of either, and the largest step of a motor force meanwhile.
//!
//! Both peers' control periods are the engine's, so that the instants of a restart against the other's packets are whole periods; the phases of the two peers' packets change with every restart.

use cohold_core::peer::Actuators;
use cohold_core::safety::Mode;
use cohold_live::Error;
use cohold_live::node::Node;
use cohold_protocol::key::Key;
use cohold_sim::engine::{Actor, Engine, EngineView, Out, Seat, Turn};
use cohold_sim::{network::link::Route, network::rule::Direction, plant::Plant, rng::Rng, scene::Scene};

/// Longest that two peers may take to engage, s.
const PATIENCE_S: f64 = 2.0;
/// Longest time from engaging to the next restart, packet periods: well before and well after full coordination is regained.
const LONGEST_PEACE_PACKETS: u64 = 16;

/// What the restarts showed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Report {
    /// Number of restarts that were made.
    pub restarts: u64,
    /// Restarts after which the peers were not engaged again within [`PATIENCE_S`].
    pub failed: u64,
    /// Restarts after which the one that stayed never let go.
    pub held_on: u64,
    /// Peers that stopped with a fault.
    pub faults: u64,
    /// Longest time from a restart until both are engaged, ms.
    pub slowest_ms: f64,
    /// Largest motor force in the first tick after arming, N.
    pub arming_force_n: f64,
    /// Largest coordination force in the first tick of an engagement, N: the first degradation step.
    pub first_force_n: f64,
    /// Largest coordination force in the first tick after letting go, N.
    pub let_go_n: f64,
    /// Largest step of a motor force from tick to tick, N.
    pub largest_step_n: f64,
}

/// One peer between restarts.
struct Life {
    node: Node,
    /// The other one's seat.
    to: usize,
    /// What it did last, and before.
    did: [Actuators<f32>; 2],
    engaged: bool,
    /// It was seen not engaged since the last restart of either.
    let_go: bool,
}

impl Life {
    fn new(scene: &Scene, number: u8, device: Plant, rng: &mut Rng) -> Result<Self, Error> {
        let entropy = [(); Key::LEN].map(|()| rng.below(256) as u8);
        let node = Node::with_device(scene, number, Key::new([0x5a; Key::LEN]), entropy, Box::new(device))?;
        Ok(Self { node, to: usize::from(number == 1), did: [Actuators::default(); 2], engaged: false, let_go: true })
    }
}

impl Actor<usize> for Life {
    type Packet = [u8];

    fn hear(&mut self, now_ns: u64, _: usize, datagram: &mut [u8], _: &mut Out<'_, usize, [u8]>) {
        // What a network broke, or was sent to an earlier life, is refused.
        let _ = self.node.receive(now_ns / 1_000, datagram);
    }

    fn speak(&mut self, now_ns: u64, out: &mut Out<'_, usize, [u8]>) {
        self.did = [self.node.tick(now_ns / 1_000, |bytes| out(self.to, bytes)), self.did[0]];
    }
}

/// Two nodes and the network between them.
struct World<'a> {
    scene: &'a Scene,
    rng: Rng,
    engine: Engine<Life>,
    report: Report,
}

/// Takes in what a peer did.
fn measure(report: &mut Report, life: &mut Life) {
    let engaged = life.node.peer.is_engaged();
    if engaged && !life.engaged {
        let first = f64::from(life.node.observed().coordination_force).abs();
        report.first_force_n = report.first_force_n.max(first);
    }
    if life.engaged && !engaged {
        report.let_go_n = report.let_go_n.max(f64::from(life.node.observed().coordination_force).abs());
    }
    life.engaged = engaged;
    life.let_go |= !engaged;
    let [force_n, force_before_n] = life.did.map(|actuators| f64::from(actuators.forces[0]));
    if life.did[0].enable && !life.did[1].enable {
        report.arming_force_n = report.arming_force_n.max(force_n.abs());
    }
    report.largest_step_n = report.largest_step_n.max((force_n - force_before_n).abs());
}

impl World<'_> {
    /// One control period of both.
    fn step(&mut self) {
        let report = &mut self.report;
        self.engine.step(&mut |seen: EngineView<'_, Life>| {
            if seen.turn == Turn::Spoke {
                measure(report, &mut seen.seats[seen.seat].actor);
            }
        });
    }

    fn lives(&mut self) -> impl Iterator<Item = &mut Life> {
        self.engine.seats.iter_mut().map(|seat| &mut seat.actor)
    }

    /// Until both have let go and engaged anew; the time that took, s, if it was within the patience.
    fn meet(&mut self) -> Option<f64> {
        let start_ns = self.engine.now_ns();
        loop {
            let spent_s = (self.engine.now_ns() - start_ns) as f64 * 1e-9;
            if self.lives().all(|life| life.engaged && life.let_go) {
                return Some(spent_s);
            }
            if spent_s >= PATIENCE_S {
                return None;
            }
            self.step();
        }
    }
}

/// Restarts one peer or the other `count` times; the seed is of the instants and of the peers' keys.
///
/// # Errors
/// A scene that cannot be built.
pub(super) fn run(scene: &Scene, count: u64, seed: u64) -> Result<Report, Error> {
    let mut rng = Rng::new(seed);
    let timing = &scene.peer.timing;
    let mut life = |number: u8| Life::new(scene, number, Plant::new(scene, usize::from(number) - 1), &mut rng);
    let seats = [life(1)?, life(2)?].map(Seat::new).into();
    let direction = |from| if from == 0 { Direction::OneToTwo } else { Direction::TwoToOne };
    let route = |from, _| Route::of_scene(scene, direction(from), 0);
    let engine = Engine::new(timing.control_period_ns(), seats, route);
    let mut world = World { scene, rng, engine, report: Report::default() };
    if world.meet().is_none() {
        return Err(format!("the two peers do not meet within {PATIENCE_S} s: is the network worse than that?").into());
    }
    for _ in 0..count {
        let peace = world.rng.below(LONGEST_PEACE_PACKETS * u64::from(timing.ticks_per_packet) + 1);
        (0..peace).for_each(|_| world.step());
        let peer = world.rng.below(2) as usize;
        world.engine.seats[1 - peer].actor.let_go = false;
        let device = world.engine.seats[peer].actor.node.device();
        world.engine.seats[peer].actor = Life::new(world.scene, peer as u8 + 1, device, &mut world.rng)?;
        let met = world.meet();
        world.report.restarts += 1;
        world.report.failed += u64::from(met.is_none());
        world.report.held_on += u64::from(!world.engine.seats[1 - peer].actor.let_go);
        let met_s = met.unwrap_or(PATIENCE_S);
        world.report.slowest_ms = world.report.slowest_ms.max(1e3 * met_s);
        let faulted = |life: &&mut Life| matches!(life.node.peer.mode(), Mode::Faulted(_));
        world.report.faults += world.lives().filter(faulted).count() as u64;
    }
    Ok(world.report)
}
