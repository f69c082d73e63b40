//! The two peers with devices and hands, and the network between them: what [`haptic_sim::pair::Pair`] is in a run, with hands
//! that come and go, and settings that change in flight.
//!
//! **What a change does.** Keys of the network act at once, on what is sent from then on. Everything else is what a peer is configured with
//! before it is armed: both start anew, at rest, where the middle of their devices is, and hands let go. Peers whose motors are off,
//! because they were stopped or because of a fault, stay so until they are asked to start.
//!
//! **Ends of travel.** A device can go [`REACH_M`] to either side; there a spring of [`END_STIFFNESS`] and a damper push back.

use haptic_core::device::AXES;
use haptic_core::num::Motion;
use haptic_core::safety::Command as Order;
use haptic_core::{law::Sends, settings::Refused};
use haptic_sim::measure::port::ObjectPort;
use haptic_sim::network::{link::Route, rule::Direction};
use haptic_sim::{DynPeer, pair::Pair, scene::Scene};

use super::environment::{ARMED, Column, Command, Environment, MOST, Sample, Standing, number_of};
use super::hand::Hand;
use super::partner::{Model, Partner};
use crate::Error;

/// Farthest that a device goes from the middle, m.
pub(crate) const REACH_M: f64 = 0.12;
/// The ends of its travel, N/m and N·s/m.
const END_STIFFNESS: f64 = 500.0;
const END_DAMPING: f64 = 5.0;
/// Real time means this control period, s.
pub(super) const PERIOD_S: f64 = 0.001;

/// What is in a sample, with unit and meaning; of peer 1 first where there are two. Every window gets this list.
pub(super) const COLUMNS: [Column; MOST] = [
    ("wanted_1", "m", "hand of person 1, no number while it holds nothing"),
    ("wanted_2", "m", "hand of person 2"),
    ("device_1", "m", "device 1"),
    ("device_2", "m", "device 2"),
    ("object_1", "m", "copy of the object at peer 1"),
    ("object_2", "m", "copy of the object at peer 2"),
    ("decoded_1", "m", "where peer 1 believes the other copy to be"),
    ("decoded_2", "m", "where peer 2 believes the other copy to be"),
    ("contact_1", "N", "force of device 1 on its copy"),
    ("contact_2", "N", "force of device 2 on its copy"),
    ("coordination_1", "N", "coordination force F_T on copy 1"),
    ("coordination_2", "N", "coordination force F_T on copy 2"),
    ("hand_1", "N", "force of hand 1 on its device"),
    ("hand_2", "N", "force of hand 2 on its device"),
    ("line", "J", "energy in the line: sent by both and not yet received"),
    (
        "kept_1",
        "J",
        "energy that the coordination of peer 1 took in and neither gave out nor stores; below 0 it makes energy",
    ),
    ("kept_2", "J", "the same of peer 2"),
    ("delay_1", "s", "how long the newest packet was on its way to peer 1"),
    ("delay_2", "s", "how long the newest packet was on its way to peer 2"),
    ("live_1", "", "1 while what peer 1 hears is fresh, or its line lives; 0 while it stands"),
    ("live_2", "", "the same of peer 2"),
    ("restarts", "", "how often both have started anew"),
];

/// What one peer's part of a sample needs to know of the tick before.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    port: ObjectPort,
    /// Packets heard, and ticks that the line has lived.
    heard: u64,
    live_ticks: u32,
    /// Ticks since the last packet.
    silent: u32,
    /// Such a peer's line counts its own time, and lives while its counter moves; another's while packets come this soon, ticks.
    counts: bool,
    patience: u32,
}

/// What a tick of one peer comes to.
pub(super) struct TickOutcome {
    /// Energy sent and not received, and kept, J.
    pub(super) sent_j: f64,
    pub(super) kept_j: f64,
    /// 1 while what it hears is fresh, or its line lives.
    pub(super) live: f32,
}

impl Side {
    pub(super) fn new(scene: &Scene) -> Self {
        let port = ObjectPort::new(PERIOD_S, scene.peer.coordination.stiffness_n_per_m);
        let (counts, patience) = (scene.law().sends == Sends::Counters, scene.peer.timing.ticks_per_packet);
        Self { port, heard: 0, live_ticks: 0, silent: 0, counts, patience }
    }

    /// After a tick of this peer, which has heard so many packets.
    pub(super) fn see(&mut self, peer: &dyn DynPeer<f32>, heard: u64) -> TickOutcome {
        let [ledger] = peer.ledger();
        let [received, sent] = [ledger.received_j(), ledger.sent_j()].map(f64::from);
        self.port.see(&peer.observed()[0].map(f64::from));
        let energy = self.port.with_network(received, sent);
        let kept_j = received + energy.from_object_j - sent - energy.to_object_j - energy.stored_j;
        let live_ticks = peer.outgoing()[0].live_ticks;
        self.silent = if heard == self.heard { self.silent.saturating_add(1) } else { 0 };
        let live = if self.counts { live_ticks != self.live_ticks } else { self.silent < self.patience };
        (self.heard, self.live_ticks) = (heard, live_ticks);
        TickOutcome { sent_j: sent - received, kept_j, live: f32::from(u8::from(live)) }
    }
}

/// Everything that is stepped.
pub(super) struct Session {
    scene: Scene,
    pair: Pair<f32>,
    hands: [Hand; 2],
    partners: [Partner; 2],
    sides: [Side; 2],
    /// Forces of the hands in this tick, N.
    pulls: [f64; 2],
    tick: u64,
    restarts: u32,
    cut: bool,
}

impl Session {
    /// Both peers armed and at rest.
    pub(super) fn new(scene: Scene, partner: Model) -> Result<Self, Refused<'static>> {
        let pair = Pair::new(&scene)?;
        Ok(Self {
            pair,
            hands: Default::default(),
            partners: [Partner::new(partner); 2],
            sides: sides(&scene),
            pulls: [0.0; 2],
            tick: 0,
            restarts: 0,
            cut: false,
            scene,
        })
    }

    fn change(&mut self, scene: Scene) -> Result<(), Refused<'static>> {
        let before = std::mem::replace(&mut self.scene, scene);
        // What the receivers were built with is no more the network's.
        let built = |scene: &Scene| (scene.world.network.playout_packets, scene.world.network.clock_drift_ppm);
        if built(&before) != built(&self.scene) || !same_but_for_network(&before, &self.scene) {
            let armed = self.modes() == [ARMED; 2];
            self.start()?;
            if !armed {
                self.stop();
            }
            return Ok(());
        }
        for direction in [Direction::OneToTwo, Direction::TwoToOne] {
            let Route { delay_ns, rule, .. } = Route::of_scene(&self.scene, direction, 0);
            let route = self.pair.route(direction);
            (route.delay_ns, route.rule) = (delay_ns, rule);
        }
        Ok(())
    }

    /// Both peers start anew, armed, in the middle of where their devices are; hands let go.
    pub(super) fn start(&mut self) -> Result<(), Refused<'static>> {
        let [one, two] = [0, 1].map(|index| self.device(index).position);
        let middle = (0.5 * (one + two)).clamp(-REACH_M, REACH_M);
        // What has left the range of numbers starts from the middle of the table.
        let mut by_m = [0.0; AXES];
        by_m[0] = if middle.is_finite() { middle } else { 0.0 };
        self.pair = Pair::starting_at(&self.scene, by_m)?;
        self.sides = sides(&self.scene);
        self.hands = Default::default();
        self.partners.iter_mut().for_each(Partner::rest);
        self.restarts += 1;
        self.cut(self.cut);
        Ok(())
    }

    /// Motors off, at both.
    pub(super) fn stop(&mut self) {
        self.pair.sides_mut().for_each(|side| side.peer.command(Order::Disarm));
    }

    /// Cuts the line both ways, or joins it again.
    pub(super) fn cut(&mut self, cut: bool) {
        self.cut = cut;
        for direction in [Direction::OneToTwo, Direction::TwoToOne] {
            self.pair.route(direction).cut = cut;
        }
    }

    /// Mode of either peer.
    pub(super) fn modes(&self) -> [u8; 2] {
        self.pair.sides().map(|side| number_of(side.peer.mode()))
    }

    fn device(&self, index: usize) -> Motion<f64> {
        self.pair.sides()[index].plant.motions()[0]
    }

    fn advance(&mut self) -> Sample {
        for index in 0..2 {
            let Motion { position, velocity } = self.device(index);
            self.pulls[index] = self.hands[index].pull(self.tick, position, velocity, PERIOD_S);
        }
        for (side, pull) in self.pair.sides_mut().zip(self.pulls) {
            side.plant.pull([pull - end_of_travel(side.plant.motions()[0]), 0.0]);
        }
        self.pair.step();
        self.tick += 1;
        self.sample()
    }

    fn sample(&mut self) -> Sample {
        let [one, two] = [0, 1].map(|at| {
            let side = self.pair.sides()[at];
            (*side.peer.observed()[0], self.sides[at].see(&*side.peer, side.delivered()), side.delay_ns as f64 * 1e-9)
        });
        let ((a, seen_a, delay_a), (b, seen_b, delay_b)) = (one, two);
        let wanted = |at: usize| self.hands[at].holds().map_or(f32::NAN, |at| at as f32);
        [
            wanted(0),
            wanted(1),
            self.device(0).position as f32,
            self.device(1).position as f32,
            a.object.position,
            b.object.position,
            a.desired.position,
            b.desired.position,
            a.contact_force,
            b.contact_force,
            a.coordination_force,
            b.coordination_force,
            self.pulls[0] as f32,
            self.pulls[1] as f32,
            (seen_a.sent_j + seen_b.sent_j) as f32,
            seen_a.kept_j as f32,
            seen_b.kept_j as f32,
            delay_a as f32,
            delay_b as f32,
            seen_a.live,
            seen_b.live,
            self.restarts as f32,
        ]
    }
}

impl Environment for Session {
    fn command(&mut self, command: Command) -> Result<(), Error> {
        match command {
            Command::Stop => self.stop(),
            Command::Start => self.start()?,
            Command::Cut(cut) => self.cut(cut),
            Command::Partner(model) => self.partners = [Partner::new(model); 2],
            Command::Board(..) => {}
        }
        Ok(())
    }

    fn set(&mut self, scene: Scene) -> Result<(), Error> {
        Ok(self.change(scene)?)
    }

    fn point(&mut self, index: usize, pointer: Option<[f64; 2]>, restarts: u32) {
        self.partners[index].rest();
        let pointer = pointer.filter(|_| restarts == self.restarts).map(|[along, _]| along);
        self.hands[index].point(self.tick, pointer, self.device(index).position);
    }

    fn play(&mut self, index: usize) {
        let device = self.device(index).position;
        let wanted = self.partners[index].wants(device, PERIOD_S);
        self.hands[index].point(self.tick, wanted, device);
    }

    fn step(&mut self) -> Result<Sample, Error> {
        Ok(self.advance())
    }

    fn standing(&self) -> Standing {
        Standing { modes: self.modes(), cut: self.cut, partner: self.partners[0].model.number() }
    }
}

/// Force of the end of its travel on a device, N, to be taken from what pulls it.
pub(super) fn end_of_travel(Motion { position, velocity }: Motion<f64>) -> f64 {
    let beyond = position - position.clamp(-REACH_M, REACH_M);
    if beyond == 0.0 { 0.0 } else { END_STIFFNESS * beyond + END_DAMPING * velocity }
}

/// Whether two scenes are the same but for their networks.
pub(super) fn same_but_for_network(one: &Scene, other: &Scene) -> bool {
    let settings_of = |scene: &Scene| scene.settings().into_iter().filter(|(key, _)| !key.starts_with("network."));
    settings_of(one).eq(settings_of(other))
}

fn sides(scene: &Scene) -> [Side; 2] {
    [Side::new(scene); 2]
}

#[cfg(test)]
#[path = "../../tests/inside/session.rs"]
mod tests;
