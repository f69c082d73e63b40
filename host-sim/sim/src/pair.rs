//! Two peers, two devices and a network, stepped together.
//!
//! The pair does for a simulated device what the board's interrupt does for a real one: read, tick, command, and a
//! packet every M ticks. Time and randomness are arguments, so a run is a function of its scene: the same bits on every
//! machine and any number of threads ([`Pair::hash`]).

use haptic_core::peer::{Actuators, Sensors};
use haptic_core::safety::{Command, Fault, Mode};
use haptic_core::{law::Packet, num::Scalar, settings::Refused};

use crate::engine::{Actor, Engine, Out, Seat, Turn};
use crate::network::link::{Inbox, Numbered, Route};
use crate::peers::{DynPeer, Number};
use crate::{network::rule::Direction, plant::Plant, scene::Scene};

/// What a peer reads and moves: a plant, or several side by side.
pub trait Device<S: Scalar> {
    /// What the peer's sensors say now.
    fn sensors(&self) -> Sensors<S>;
    /// One control period from `time_s` on, under what the peer commands.
    fn step(&mut self, time_s: f64, actuators: &Actuators<S>);
    /// Whether the clutch is held open at `time_s`.
    fn clutches(&self, _time_s: f64) -> bool {
        false
    }
}

impl<S: Scalar> Device<S> for Plant {
    #[inline]
    fn sensors(&self) -> Sensors<S> {
        self.sensors()
    }
    #[inline]
    fn step(&mut self, time_s: f64, actuators: &Actuators<S>) {
        self.step(time_s, actuators);
    }
    #[inline]
    fn clutches(&self, time_s: f64) -> bool {
        self.clutches(time_s)
    }
}

/// One peer with its device, for an engine.
pub struct Side<S: Scalar, D = Plant> {
    /// The peer.
    pub peer: Box<dyn DynPeer<S>>,
    /// Its device and user.
    pub plant: D,
    inbox: Inbox<Packet<S>>,
    /// The seat that its packets are for.
    to: usize,
    /// Packet periods so far: the number of the next packet.
    number: u64,
    /// Packets sent so far.
    pub sent: u64,
    /// How long the packet that came last was on its way, ns.
    pub delay_ns: u64,
    period_s: f64,
    period_ns: u64,
    packet_ns: u64,
    heard: Option<Packet<S>>,
    exchanged: bool,
    /// The clutch is open.
    clutched: bool,
    sensors: Sensors<S>,
    actuators: Actuators<S>,
}

impl<S: Number> Side<S> {
    /// Peer `index` (0 or 1) of a scene, armed and at rest, which writes to seat `to`.
    pub fn new(scene: &Scene, index: usize, to: usize) -> Result<Self, Refused<'static>> {
        Self::starting_at(scene, index, to, 0.0)
    }

    /// The same with its device `at_m` further along the free axis than the scene puts it.
    fn starting_at(scene: &Scene, index: usize, to: usize, at_m: f64) -> Result<Self, Refused<'static>> {
        let plant = Plant::new(scene, index).moved(at_m);
        let peer = scene.peer_from(index, plant.motions())?;
        Ok(Self::of(scene, peer, plant, to))
    }
}

impl<S: Scalar, D: Device<S>> Side<S, D> {
    /// This peer, which is armed, at this device.
    pub(crate) fn of(scene: &Scene, mut peer: Box<dyn DynPeer<S>>, plant: D, to: usize) -> Self {
        peer.command(Command::Arm);
        Self {
            sensors: plant.sensors(),
            peer,
            plant,
            inbox: Inbox::new(scene, 1),
            to,
            number: 0,
            sent: 0,
            delay_ns: 0,
            period_s: scene.peer.timing.control_period_s,
            period_ns: scene.peer.timing.control_period_ns(),
            packet_ns: scene.peer.timing.packet_period_ns(),
            heard: None,
            exchanged: false,
            clutched: false,
            actuators: Actuators::default(),
        }
    }

    /// Packets that the peer has taken in.
    pub fn delivered(&self) -> u64 {
        self.inbox.delivered
    }
}

/// Both packets are made before either is taken in: a network without delay delivers within the tick.
impl<S: Scalar, D: Device<S>> Actor<usize> for Side<S, D> {
    type Packet = Numbered<Packet<S>>;

    #[inline]
    fn hear(&mut self, now_ns: u64, _: usize, packet: &mut Self::Packet, _: &mut Out<'_, usize, Self::Packet>) {
        self.delay_ns = now_ns.saturating_sub(packet.number * self.packet_ns);
        self.inbox.put(now_ns, *packet);
    }

    #[inline]
    fn speak(&mut self, _: u64, out: &mut Out<'_, usize, Self::Packet>) {
        if self.peer.packet_due() {
            if let Some(what) = self.peer.speak() {
                out(self.to, &Numbered { number: self.number, what });
                self.sent += 1;
            }
            self.number += 1;
        }
    }

    #[inline]
    fn act(&mut self, now_ns: u64, _: &mut Out<'_, usize, Self::Packet>) {
        // In most ticks nothing: a packet of sixteen lanes is not copied then.
        self.heard = None;
        if let Some(packet) = self.inbox.take(now_ns) {
            self.peer.hear(packet);
            self.heard = Some(packet);
        }
        self.exchanged = self.peer.packet_due();
        if self.exchanged {
            self.peer.listen();
        }
        let time_s = (now_ns / self.period_ns) as f64 * self.period_s;
        let clutched = self.plant.clutches(time_s);
        if clutched != self.clutched {
            self.clutched = clutched;
            self.peer.command(if clutched { Command::Clutch } else { Command::Release });
        }
        self.sensors = self.plant.sensors();
        let actuators = self.peer.tick(&self.sensors);
        self.plant.step(time_s, &actuators);
        self.actuators = actuators;
    }
}

/// What a tick of a peer read and did.
#[derive(Debug)]
pub struct Seen<'a, S: Scalar> {
    /// Which peer, 1 or 2.
    pub number: usize,
    /// What it heard before the tick.
    pub heard: Option<Packet<S>>,
    /// An exchange was due before the tick.
    pub exchanged: bool,
    /// What the tick read.
    pub sensors: &'a Sensors<S>,
    /// What it commanded.
    pub actuators: &'a Actuators<S>,
    /// The peer as the tick left it.
    pub peer: &'a mut dyn DynPeer<S>,
}

/// Two peers on one network, computing in `S`.
pub struct Pair<S: Scalar, D: Device<S> = Plant> {
    engine: Engine<Side<S, D>>,
    period_s: f64,
}

impl<S: Number> Pair<S> {
    /// Both peers armed and at rest.
    pub fn new(scene: &Scene) -> Result<Self, Refused<'static>> {
        Self::starting_at(scene, 0.0)
    }

    /// The same with both devices, and the object between them, `at_m` further along the free axis than the scene puts them.
    pub fn starting_at(scene: &Scene, at_m: f64) -> Result<Self, Refused<'static>> {
        let side = |index, to| Side::starting_at(scene, index, to, at_m);
        Ok(Self::of(scene, [side(0, 1)?, side(1, 0)?]))
    }
}

impl<S: Scalar, D: Device<S>> Pair<S, D> {
    /// These two, on the network of the scene.
    pub(crate) fn of(scene: &Scene, sides: [Side<S, D>; 2]) -> Self {
        let [first, mut second] = sides.map(Seat::new);
        second.period = 1.0 + 1e-6 * scene.world.network.clock_drift_ppm;
        let direction = |from| if from == 0 { Direction::OneToTwo } else { Direction::TwoToOne };
        let route = |from, _| Route::of_scene(scene, direction(from), 0);
        let engine = Engine::new(scene.peer.timing.control_period_ns(), vec![first, second], route);
        Self { engine, period_s: scene.peer.timing.control_period_s }
    }

    /// Peer 1 (left) and peer 2 (right).
    #[inline]
    pub fn sides(&self) -> [&Side<S, D>; 2] {
        [0, 1].map(|at| &self.engine.seats[at].actor)
    }

    /// The same, to be changed.
    pub fn sides_mut(&mut self) -> impl Iterator<Item = &mut Side<S, D>> {
        self.engine.seats.iter_mut().map(|seat| &mut seat.actor)
    }

    /// The network in one direction, to be put under another rule or cut while it is in use.
    pub fn route(&mut self, direction: Direction) -> &mut Route {
        let [from, to] = if direction == Direction::OneToTwo { [0, 1] } else { [1, 0] };
        self.engine.route(from, to)
    }

    /// Ticks done so far, n.
    pub fn tick(&self) -> u64 {
        self.engine.tick()
    }

    /// Packets that a peer has sent, mean of both, 1/s.
    pub fn packets_per_s(&self) -> f64 {
        self.sides().iter().map(|side| side.sent).sum::<u64>() as f64 / (2.0 * self.time_s())
    }

    /// Time of the next tick, s.
    pub fn time_s(&self) -> f64 {
        self.engine.tick() as f64 * self.period_s
    }

    /// One true control period: a tick of both peers and devices; of peer 2 now and then none or two, where its clock
    /// drifts.
    #[inline]
    pub fn step(&mut self) {
        self.engine.step(&mut |_| ());
    }

    /// The same, telling `each` what every tick of either peer read and did.
    #[inline]
    pub fn step_watched(&mut self, each: &mut impl FnMut(Seen<'_, S>)) {
        self.engine.step(&mut |turn| {
            let Side { heard, exchanged, sensors, actuators, peer, .. } = &mut turn.seats[turn.seat].actor;
            if turn.turn == Turn::Acted {
                let (heard, exchanged) = (*heard, *exchanged);
                each(Seen { number: turn.seat + 1, heard, exchanged, sensors, actuators, peer: &mut **peer });
            }
        });
    }

    /// The fault that stopped either peer, if any, with the peer's number (1 or 2).
    pub fn fault(&self) -> Option<(usize, Fault)> {
        self.sides().iter().enumerate().find_map(|(index, side)| match side.peer.mode() {
            Mode::Faulted(fault) => Some((index + 1, fault)),
            _ => None,
        })
    }

    /// A hash (FNV-1a over 64-bit words) of the bits of both peers' dynamic states, continued from `seed`.
    pub fn hash(&self, seed: u64) -> u64 {
        self.sides().iter().fold(seed, |hash, side| side.peer.hash(hash))
    }
}

/// Where [`Pair::hash`] starts.
pub const HASH_SEED: u64 = 0xcbf2_9ce4_8422_2325;
