//! Two honest peers and a hostile one at a hub without seals: what is taken in and what is computed is a hub's and its peers', and ten
//! thousand programs take seconds.

use std::collections::VecDeque;

use cohold_core::safety::{Command, Mode};
use cohold_core::settings::{Safety, Settings, Value};
use cohold_environments::cooperative::junction::{Junction, Port};
use cohold_protocol::peer::{Inbox, flow_of, packets_of};
use cohold_protocol::wire::Flows;
use cohold_sim::peers::{Builds, DynPeer};
use cohold_sim::plant::Plant;
use cohold_sim::scene::Scene;

/// The line of the hostile one.
const HOSTILE: usize = 2;
/// Ticks from end to end of a line.
const DELAY: usize = 4;

/// Ticks from when motors went off to when somebody turns them on again.
const OFF: u32 = 50;
/// Most ticks until copies are at rest.
const MOST_RESTING: u32 = 60_000;

/// An honest peer with its device, and the hub's flow to it.
pub(super) struct Honest<const SHARED: usize, const N: usize> {
    pub(super) peer: Box<dyn DynPeer<f32, SHARED, N>>,
    plant: Plant<N>,
    inbox: Inbox<SHARED>,
    forces_n: [f32; N],
    /// Largest force on the hand along an axis, N; fastest copy along one, m/s.
    pub(super) force_most_n: f64,
    pub(super) speed_most: f64,
    /// Ticks that its motors have been off, and times that they went off.
    off: u32,
    pub(super) faults: u32,
}

/// Everybody at one hub.
pub(super) struct Table<const SHARED: usize, const N: usize> {
    scene: Scene,
    junction: Junction<SHARED>,
    inboxes: Vec<Inbox<SHARED>>,
    pub(super) honest: Vec<Honest<SHARED, N>>,
    up: [VecDeque<Option<Flows<SHARED>>>; 3],
    down: [VecDeque<Option<Flows<SHARED>>>; 2],
    pub(super) tick: u32,
    /// Flows of the hostile one that were let in, and that were not.
    pub(super) taken: [u64; 2],
    /// 3·√(2/b)·U, m/s.
    speed_bound: f64,
    pub(super) bound: f64,
}

impl<const SHARED: usize, const N: usize> Table<SHARED, N>
where
    f32: Builds<SHARED, N>,
{
    /// A table whose hub takes what is within the limits of the scene, or of `limits` instead.
    pub(super) fn new(scene: Scene, limits: Option<Safety>) -> Self {
        let peers = scene.peers().map(|peer| Settings { safety: limits.unwrap_or(peer.safety), ..peer });
        let ticks_per_packet = scene.peer.timing.ticks_per_packet;
        let mut junction = Junction::new(&scene, 3).expect("waves");
        (0..3).for_each(|line| junction.part(line));
        let bounds = [0, 1, 0].map(|index| scene.laws.bounds(&peers[index]));
        // Of the waves themselves: what a packet says for one may be more.
        let mut waves = scene.peer;
        waves.set("coordination.even_s", Value::Number(0.0)).expect("it is allowed");
        let bound = scene.laws.bounds(&waves).wave();
        let honest = (0..2).map(|index| {
            let plant = Plant::build(&scene, index);
            let mut peer: Box<dyn DynPeer<f32, SHARED, N>> = scene.peer_from(index, plant.motions()).expect("a peer");
            peer.command(Command::Arm);
            peer.part();
            let inbox = Inbox::new(bounds[index].beyond_a_junction(), 0, ticks_per_packet);
            Honest { peer, plant, inbox, forces_n: [0.0; N], force_most_n: 0.0, speed_most: 0.0, off: 0, faults: 0 }
        });
        Self {
            junction,
            inboxes: bounds.iter().map(|bounds| Inbox::new(*bounds, 0, ticks_per_packet)).collect(),
            honest: honest.collect(),
            up: [(); 3].map(|()| VecDeque::from([None; DELAY])),
            down: [(); 2].map(|()| VecDeque::from([None; DELAY])),
            tick: 0,
            taken: [0; 2],
            speed_bound: 3.0 * (2.0 / scene.peer.coordination.wave_impedance_n_s_per_m).sqrt() * bound,
            bound,
            scene,
        }
    }

    pub(super) fn ticks_per_packet(&self) -> u32 {
        self.scene.peer.timing.ticks_per_packet
    }

    /// Whether packets are due.
    pub(super) fn is_due(&self) -> bool {
        self.tick.is_multiple_of(self.ticks_per_packet())
    }

    /// The hostile one is gone, as its link says, which takes nothing more of it.
    pub(super) fn gone(&mut self) {
        self.up[HOSTILE].iter_mut().for_each(|flow| *flow = None);
        self.inboxes[HOSTILE].clear();
    }

    /// One control period, in which the hostile one says this.
    pub(super) fn step(&mut self, hostile: Option<Flows<SHARED>>) {
        let safety = self.scene.peer.safety;
        let period_s = self.scene.peer.timing.control_period_s;
        for (honest, (up, down)) in self.honest.iter_mut().zip(self.up.iter_mut().zip(&mut self.down)) {
            if let Some(flow) = down.pop_front().flatten() {
                honest.inbox.put(self.tick, flow).expect("a hub says what can be, whatever is said to it");
            }
            let (flow, parted) = honest.inbox.take();
            if parted {
                honest.peer.part();
            }
            if let Some(flow) = flow {
                honest.peer.hear(&packets_of(&flow));
            }
            let said = honest.peer.packet_due().then(|| honest.peer.exchange()).flatten();
            up.push_back(said.map(|packets| flow_of(packets, honest.peer.mode() == Mode::Armed, self.tick)));
            let actuators = honest.peer.tick(&honest.plant.sensors());
            honest.plant.step(f64::from(self.tick) * period_s, &actuators);
            let armed = honest.peer.mode() == Mode::Armed;
            for (force_n, before_n) in actuators.forces.iter().zip(&mut honest.forces_n) {
                assert!(f64::from(force_n.abs()) <= safety.max_force_n * (1.0 + 1e-6), "{force_n} N");
                let from_n = if *force_n > 0.0 { before_n.max(0.0) } else { before_n.min(0.0) };
                let step_n = f64::from(force_n.abs() - from_n.abs());
                let slew_n = safety.max_slew_n_per_s * period_s * (1.0 + 1e-5);
                assert!(!armed || step_n <= slew_n, "a step of {step_n} N");
                *before_n = *force_n;
                honest.force_most_n = honest.force_most_n.max(f64::from(force_n.abs()));
            }
            for seen in honest.peer.observed() {
                let numbers = [seen.object, seen.desired, seen.device];
                assert!(numbers.iter().all(|motion| motion.is_finite()), "{seen:?}");
                assert!(seen.contact_force.is_finite() && seen.coordination_force.is_finite(), "{seen:?}");
                honest.speed_most = honest.speed_most.max(f64::from(seen.object.velocity.abs()));
                assert!(honest.speed_most <= self.speed_bound, "{seen:?}");
                let device = f64::from(seen.device.velocity.abs());
                assert!(!armed || device <= safety.max_speed_m_per_s * (1.0 + 1e-6), "{seen:?}");
            }
            honest.faults += u32::from(!armed && honest.off == 0);
            honest.off = if armed { 0 } else { honest.off + 1 };
            if honest.off == OFF {
                // Whoever sits there clears it and goes on.
                honest.peer.command(Command::Clear);
                honest.peer.command(Command::Arm);
                honest.peer.part();
            }
        }
        self.up[HOSTILE].push_back(hostile);
        for (line, (inbox, up)) in self.inboxes.iter_mut().zip(&mut self.up).enumerate() {
            let Some(flow) = up.pop_front().flatten() else { continue };
            let put = inbox.put(self.tick, flow);
            match line {
                HOSTILE => self.taken[usize::from(put.is_err())] += 1,
                _ => put.expect("an honest peer says what can be"),
            }
        }
        let due = self.is_due();
        if self.junction.is_due(due) {
            let mut came = [None; 3];
            for (line, (inbox, came)) in self.inboxes.iter_mut().zip(&mut came).enumerate() {
                let (flow, parted) = inbox.take();
                if parted {
                    self.junction.part(line);
                }
                *came = flow.as_ref().map(packets_of);
            }
            self.junction.exchange(came, due);
        }
        assert!(self.junction.motion.iter().all(|motion| motion.is_finite()), "{:?}", self.junction.motion);
        for (down, port) in self.down.iter_mut().zip(&self.junction.ports) {
            assert!(port.back().iter().all(|back| back.is_finite()), "{port:?}");
            down.push_back(due.then(|| flow_of(port.back(), true, self.tick)));
        }
        self.tick += 1;
    }

    /// Goes on until the honest copies have moved by less than 1 mm/s for a second: a contact that slipped under what the hostile one pushed with
    /// goes back at 50 mm/s.
    pub(super) fn rest(&mut self) {
        let mut still = 0;
        for _ in 0..MOST_RESTING {
            let slow = |honest: &Honest<SHARED, N>| {
                honest.peer.observed().iter().all(|seen| seen.object.velocity.abs() < 1e-3)
            };
            let rests = self.honest.iter().all(slow);
            still = if rests { still + 1 } else { 0 };
            if still == 1_000 {
                return;
            }
            self.step(None);
        }
    }

    /// How far the honest copies are apart along the axis on which they are farthest, m.
    pub(super) fn apart_m(&self) -> f64 {
        let place = |at: usize, axis: usize| f64::from(self.honest[at].peer.observed()[axis].object.position);
        (0..SHARED).map(|axis| (place(0, axis) - place(1, axis)).abs()).fold(0.0, f64::max)
    }

    /// Whether both honest ones hold what the hub holds.
    pub(super) fn holds(&self) -> bool {
        self.honest.iter().all(|honest| honest.peer.is_engaged())
            && self.junction.ports[..HOSTILE].iter().all(Port::is_engaged)
    }
}
