//! Two peers, two devices and a network, stepped together.
//!
//! The pair does for a simulated device what the board's interrupt does for a real one: read, tick, command, and a
//! packet every M ticks. Time and randomness are arguments, so a run is a function of its scene: the same bits on every
//! machine and any number of threads ([`Pair::hash`]).

use std::borrow::Borrow;

use cohold_core::device::AXES;
use cohold_core::num::Scalar;
use cohold_core::peer::{Actuators, Sensors};
use cohold_core::safety::{Command, Fault, Mode};
use cohold_core::{law::Packet, settings::Refused};

use crate::device::Device;
use crate::engine::{Actor, Engine, Out, Seat, Turn};
use crate::network::link::{Inbox, Numbered, Route};
use crate::peers::{Builds, DynPeer, Number};
use crate::{network::rule::Direction, plant::Plant, scene::Scene};

/// What takes in the packets for a peer until its next tick.
pub trait Mailbox<S: Scalar, const SHARED: usize, const N: usize> {
    /// What packets are while they are on their way.
    type Carried: Clone;
    /// What its own peer sends, as it is carried.
    fn carried(&mut self, packets: [Packet<S>; SHARED]) -> Self::Carried;
    /// Takes a packet that came at `now_ns`, ns.
    fn put(&mut self, now_ns: u64, packet: &Numbered<Self::Carried>);
    /// Lets the peer hear what has come by `now_ns` (ns), and count the silence if an exchange of packets is due; whether it heard anything.
    fn hand_over(&mut self, now_ns: u64, due: bool, peer: &mut dyn DynPeer<S, SHARED, N>) -> bool;
    /// What the peer heard last.
    fn heard(&self) -> Option<&[Packet<S>; SHARED]>;
    /// Packets that the peer has taken in.
    fn delivered(&self) -> u64;
}

/// [`Mailbox::hand_over`] of an inbox, whatever carries the packets.
#[inline]
pub(crate) fn hand_over<S: Scalar, const SHARED: usize, const N: usize>(
    inbox: &mut Inbox<impl Borrow<[Packet<S>; SHARED]>>,
    now_ns: u64,
    due: bool,
    peer: &mut dyn DynPeer<S, SHARED, N>,
) -> bool {
    let taken = inbox.take(now_ns);
    let heard = taken.is_some();
    if let Some(packets) = taken {
        peer.hear(packets.borrow());
    } else if inbox.is_old {
        peer.delayed();
        // Live, a peer that has never used a packet is not engaged.
        if inbox.delivered == 0 {
            peer.part();
        }
    }
    if due {
        peer.listen();
    }
    heard
}

impl<S: Scalar, const SHARED: usize, const N: usize> Mailbox<S, SHARED, N> for Inbox<[Packet<S>; SHARED]> {
    type Carried = [Packet<S>; SHARED];

    #[inline]
    fn carried(&mut self, packets: [Packet<S>; SHARED]) -> Self::Carried {
        packets
    }

    #[inline]
    fn put(&mut self, now_ns: u64, packet: &Numbered<Self::Carried>) {
        Self::put(self, now_ns, *packet);
    }

    #[inline]
    fn hand_over(&mut self, now_ns: u64, due: bool, peer: &mut dyn DynPeer<S, SHARED, N>) -> bool {
        hand_over(self, now_ns, due, peer)
    }

    fn heard(&self) -> Option<&[Packet<S>; SHARED]> {
        self.taken()
    }

    fn delivered(&self) -> u64 {
        self.delivered
    }
}

/// One peer with its device, for an engine: it shares the object along `SHARED` axes of a device of `N`.
pub struct Side<
    S: Scalar,
    D = Plant,
    const SHARED: usize = 1,
    const N: usize = AXES,
    I: Mailbox<S, SHARED, N> = Inbox<[Packet<S>; SHARED]>,
> {
    /// The peer, whatever its law.
    pub peer: Box<dyn DynPeer<S, SHARED, N>>,
    /// The peer's device and user.
    pub plant: D,
    inbox: I,
    /// Index of the seat that its packets are sent to.
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
    heard: bool,
    exchanged: bool,
    /// The clutch is open.
    clutched: bool,
    sensors: Sensors<S, N>,
    actuators: Actuators<S, N>,
}

impl<S: Builds<SHARED, N>, D: Device<S, N>, const SHARED: usize, const N: usize> Side<S, D, SHARED, N> {
    /// Peer `index` (0 or 1) of a scene at this device, armed and at rest, which sends to seat `to`.
    ///
    /// # Errors
    /// The first key that the peer refuses, or an `axis.shared` that is not `SHARED`.
    pub fn new(scene: &Scene, index: usize, to: usize, device: D) -> Result<Self, Refused<'static>> {
        let peer = scene.laws.peer(&scene.peers()[index], device.start())?;
        Ok(Self::with_mailbox(scene, peer, device, to, Inbox::of_end(scene, index, 1)))
    }
}

impl<S: Scalar, D: Device<S, N>, const SHARED: usize, const N: usize> Side<S, D, SHARED, N> {
    /// This peer, which is armed, at this device.
    pub(crate) fn of(scene: &Scene, peer: Box<dyn DynPeer<S, SHARED, N>>, plant: D, to: usize) -> Self {
        Self::with_mailbox(scene, peer, plant, to, Inbox::new(scene, 1))
    }
}

impl<S: Scalar, D: Device<S, N>, const SHARED: usize, const N: usize, I: Mailbox<S, SHARED, N>>
    Side<S, D, SHARED, N, I>
{
    /// This peer, which is armed, at this device, with this mailbox.
    pub(crate) fn with_mailbox(
        scene: &Scene,
        mut peer: Box<dyn DynPeer<S, SHARED, N>>,
        plant: D,
        to: usize,
        inbox: I,
    ) -> Self {
        peer.command(Command::Arm);
        Self {
            sensors: plant.sensors(),
            peer,
            plant,
            inbox,
            to,
            number: 0,
            sent: 0,
            delay_ns: 0,
            period_s: scene.peer.timing.control_period_s,
            period_ns: scene.peer.timing.control_period_ns(),
            packet_ns: scene.peer.timing.packet_period_ns(),
            heard: false,
            exchanged: false,
            clutched: false,
            actuators: Actuators::default(),
        }
    }

    /// Packets that the peer has taken in.
    pub fn delivered(&self) -> u64 {
        self.inbox.delivered()
    }

    /// What its newest tick commanded.
    pub fn actuators(&self) -> &Actuators<S, N> {
        &self.actuators
    }
}

/// Both packets are made before either is taken in: a network without delay delivers within the tick.
impl<S: Scalar, D: Device<S, N>, const SHARED: usize, const N: usize, I: Mailbox<S, SHARED, N>> Actor<usize>
    for Side<S, D, SHARED, N, I>
{
    type Packet = Numbered<I::Carried>;

    #[inline]
    fn hear(&mut self, now_ns: u64, _: usize, packet: &mut Self::Packet, _: &mut Out<'_, usize, Self::Packet>) {
        self.delay_ns = now_ns.saturating_sub(packet.number * self.packet_ns);
        self.inbox.put(now_ns, packet);
    }

    #[inline]
    fn speak(&mut self, _: u64, out: &mut Out<'_, usize, Self::Packet>) {
        if self.peer.packet_due() {
            if let Some(packets) = self.peer.speak() {
                out(self.to, &Numbered::new(self.number, self.inbox.carried(packets)));
                self.sent += 1;
            }
            self.number += 1;
        }
    }

    #[inline]
    fn act(&mut self, now_ns: u64, _: &mut Out<'_, usize, Self::Packet>) {
        self.exchanged = self.peer.packet_due();
        self.heard = self.inbox.hand_over(now_ns, self.exchanged, &mut *self.peer);
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

/// What a peer received, read and commanded in one tick.
#[derive(Debug)]
pub struct PeerTick<'a, S: Scalar, const SHARED: usize = 1, const N: usize = AXES> {
    /// Number of the peer, 1 or 2.
    pub number: usize,
    /// Packets that the peer heard before the tick, one for each shared axis.
    pub heard: Option<&'a [Packet<S>; SHARED]>,
    /// Whether an exchange of packets was due before the tick.
    pub exchanged: bool,
    /// What the tick read.
    pub sensors: &'a Sensors<S, N>,
    /// What the tick commanded.
    pub actuators: &'a Actuators<S, N>,
    /// The peer as the tick left it.
    pub peer: &'a mut dyn DynPeer<S, SHARED, N>,
}

impl<S: Scalar, const SHARED: usize, const N: usize> PeerTick<'_, S, SHARED, N> {
    /// What the motors press with along each shared axis, N.
    #[inline]
    pub fn motors_n(&self) -> [S::Counter; SHARED] {
        // The shared axes are a device's first ones.
        std::array::from_fn(|axis| self.actuators.forces[axis].to_counter())
    }
}

/// Two peers on one network, computing in `S`, that share the object along `SHARED` axes of devices of `N`.
pub struct Pair<
    S: Scalar,
    D: Device<S, N> = Plant,
    const SHARED: usize = 1,
    const N: usize = AXES,
    I: Mailbox<S, SHARED, N> = Inbox<[Packet<S>; SHARED]>,
> {
    engine: Engine<Side<S, D, SHARED, N, I>>,
    period_s: f64,
}

/// One shared axis of simulated devices in the plane.
impl<S: Number> Pair<S> {
    /// Both peers armed and at rest, at the scene's simulated devices.
    ///
    /// # Errors
    /// The first key that a peer refuses, or an object shared along several axes, which [`Pair::build`] takes.
    pub fn new(scene: &Scene) -> Result<Self, Refused<'static>> {
        Self::build(scene)
    }
}

impl<S: Builds<SHARED, N>, const SHARED: usize, const N: usize> Pair<S, Plant<N>, SHARED, N> {
    /// Both peers armed and at rest, at the scene's simulated devices.
    ///
    /// # Errors
    /// The first key that a peer refuses, or an `axis.shared` that is not `SHARED`.
    pub fn build(scene: &Scene) -> Result<Self, Refused<'static>> {
        Self::starting_at(scene, [0.0; N])
    }

    /// [`Pair::build`] with both devices, and the object between them, displaced along each axis by so much, m.
    ///
    /// # Errors
    /// As [`Pair::build`].
    pub fn starting_at(scene: &Scene, by_m: [f64; N]) -> Result<Self, Refused<'static>> {
        Self::with_devices(scene, [0, 1].map(|index| Plant::build(scene, index).moved(by_m)))
    }
}

impl<S: Builds<SHARED, N>, D: Device<S, N>, const SHARED: usize, const N: usize> Pair<S, D, SHARED, N> {
    /// Both peers of a scene armed and at rest, at these devices, peer 1's first.
    ///
    /// # Errors
    /// The first key that a peer refuses, or an `axis.shared` that is not `SHARED`.
    pub fn with_devices(scene: &Scene, devices: [D; 2]) -> Result<Self, Refused<'static>> {
        let [first, second] = devices;
        Ok(Self::of(scene, [Side::new(scene, 0, 1, first)?, Side::new(scene, 1, 0, second)?]))
    }
}

impl<S: Scalar, D: Device<S, N>, const SHARED: usize, const N: usize> Pair<S, D, SHARED, N> {
    /// These two, on the network of the scene.
    pub(crate) fn of(scene: &Scene, sides: [Side<S, D, SHARED, N>; 2]) -> Self {
        Self::with_routes(scene, sides, |direction| Route::of_scene(scene, direction, 0))
    }
}

impl<S: Scalar, D: Device<S, N>, const SHARED: usize, const N: usize, I: Mailbox<S, SHARED, N>>
    Pair<S, D, SHARED, N, I>
{
    /// These two of the scene, with this route in each direction.
    pub(crate) fn with_routes(
        scene: &Scene,
        sides: [Side<S, D, SHARED, N, I>; 2],
        route: impl Fn(Direction) -> Route,
    ) -> Self {
        let [first, mut second] = sides.map(Seat::new);
        second.period = 1.0 + 1e-6 * scene.world.network.clock_drift_ppm;
        let route = |from, _| route(if from == 0 { Direction::OneToTwo } else { Direction::TwoToOne });
        let engine = Engine::new(scene.peer.timing.control_period_ns(), vec![first, second], route);
        Self { engine, period_s: scene.peer.timing.control_period_s }
    }

    /// Peer 1 (left) and peer 2 (right).
    #[inline]
    pub fn sides(&self) -> [&Side<S, D, SHARED, N, I>; 2] {
        [0, 1].map(|at| &self.engine.seats[at].actor)
    }

    /// Both sides, to be changed.
    pub fn sides_mut(&mut self) -> impl Iterator<Item = &mut Side<S, D, SHARED, N, I>> {
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

    /// [`Pair::step`], handing `each` what every tick of either peer read and did.
    #[inline]
    pub fn step_watched(&mut self, each: &mut impl FnMut(PeerTick<'_, S, SHARED, N>)) {
        self.engine.step(&mut |turn| {
            let Side { heard, inbox, exchanged, sensors, actuators, peer, .. } = &mut turn.seats[turn.seat].actor;
            if turn.turn == Turn::Acted {
                let (heard, exchanged) = (if *heard { inbox.heard() } else { None }, *exchanged);
                each(PeerTick { number: turn.seat + 1, heard, exchanged, sensors, actuators, peer: &mut **peer });
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

    /// [`Pair::hash`] without a copy of the peers, for who asks at every tick.
    #[inline]
    pub fn hash_in_place(&mut self, seed: u64) -> u64 {
        self.sides_mut().fold(seed, |hash, side| side.peer.hash_in_place(hash))
    }
}

/// Value that [`Pair::hash`] starts from.
pub const HASH_SEED: u64 = 0xcbf2_9ce4_8422_2325;
