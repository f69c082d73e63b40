//! Two peers, two devices and a network, stepped together.
//!
//! The pair does for a simulated device what the board's interrupt does for a real one: read, tick, command, and a
//! packet every M ticks. Time and randomness are arguments, so a run is a function of its scene: the same bits on every
//! machine and any number of threads ([`Pair::hash`]).

use haptic_core::law::Packet;
use haptic_core::num::Scalar;
use haptic_core::peer::{Actuators, Sensors};
use haptic_core::safety::{Command, Fault, Mode};
use haptic_core::settings::Refused;

use crate::network::Way;
use crate::network::rule::Direction;
use crate::peers::{DynPeer, Number};
use crate::plant::Plant;
use crate::scene::Scene;

/// One peer with its device and the line that its packets come in by.
pub struct Side<S: Scalar> {
    /// The peer.
    pub peer: Box<dyn DynPeer<S>>,
    /// Its device and user.
    pub plant: Plant,
    /// The network from the other peer to this one.
    pub incoming: Way<Packet<S>>,
}

/// What a tick of a peer read and did.
#[derive(Debug)]
pub struct Seen<'a, S: Scalar> {
    /// Which peer, 1 or 2.
    pub number: usize,
    /// The exchange before the tick, if one was due, with what it took in.
    pub exchanged: Option<Option<Packet<S>>>,
    /// What the tick read.
    pub sensors: &'a Sensors<S>,
    /// What it commanded.
    pub actuators: &'a Actuators<S>,
    /// The peer as the tick left it.
    pub peer: &'a mut dyn DynPeer<S>,
}

/// Two peers on one network, computing in `S`.
pub struct Pair<S: Scalar> {
    /// Peer 1 (left) and peer 2 (right).
    pub sides: [Side<S>; 2],
    period_s: f64,
    tick: u64,
    /// Ticks in a packet period.
    ticks_per_packet: f64,
    /// Peer 2's control period over the true one.
    drift: f64,
}

impl<S: Number> Pair<S> {
    /// Both peers armed and at rest.
    ///
    /// # Errors
    /// What [`Scene::peer`] refuses.
    pub fn new(scene: &Scene) -> Result<Self, Refused<'static>> {
        let side = |index: usize| {
            let mut peer = scene.peer(index)?;
            peer.command(Command::Arm);
            let incoming = Way::new(scene, if index == 0 { Direction::TwoToOne } else { Direction::OneToTwo }, 0);
            Ok(Side { peer, plant: Plant::new(scene, index), incoming })
        };
        Ok(Self {
            sides: [side(0)?, side(1)?],
            period_s: scene.peer.timing.control_period_s,
            tick: 0,
            ticks_per_packet: f64::from(scene.peer.timing.ticks_per_packet),
            drift: 1.0 + 1e-6 * scene.world.network.clock_drift_ppm,
        })
    }

    /// Ticks done so far, n.
    pub fn tick(&self) -> u64 {
        self.tick
    }

    /// Time of the next tick, s.
    pub fn time_s(&self) -> f64 {
        self.tick as f64 * self.period_s
    }

    /// One true control period: a tick of both peers and devices; of peer 2 now and then none or two, where its clock
    /// drifts.
    #[inline]
    pub fn step(&mut self) {
        self.step_watched(&mut |_| ());
    }

    /// The same, telling `each` what every tick of either peer read and did.
    #[inline]
    pub fn step_watched(&mut self, each: &mut impl FnMut(Seen<'_, S>)) {
        if self.drift == 1.0 {
            self.round([true, true], each);
        } else {
            let ticks = |at: u64| (at as f64 / self.drift).floor() as u64;
            let of_second = ticks(self.tick + 1) - ticks(self.tick);
            self.round([true, of_second > 0], each);
            for _ in 1..of_second {
                self.round([false, true], each);
            }
        }
        self.tick += 1;
    }

    /// One tick of the sides whose turn it is.
    #[inline]
    fn round(&mut self, turns: [bool; 2], each: &mut impl FnMut(Seen<'_, S>)) {
        let (time_s, now) = (self.time_s(), self.tick as f64 / self.ticks_per_packet);
        let [left, right] = &mut self.sides;
        let [left_due, right_due] = [turns[0] && left.peer.packet_due(), turns[1] && right.peer.packet_due()];
        // Both packets are made before either is taken in: a network without delay delivers within the tick.
        if left_due {
            right.incoming.send(now, left.peer.outgoing());
        }
        if right_due {
            left.incoming.send(now, right.peer.outgoing());
        }
        let exchanged = [(&mut *left, left_due), (&mut *right, right_due)].map(|(side, due)| {
            due.then(|| {
                let incoming = side.incoming.take(now);
                side.peer.exchange(incoming);
                incoming
            })
        });
        for (index, (side, exchanged)) in [left, right].into_iter().zip(exchanged).enumerate() {
            if turns[index] {
                let sensors = side.plant.sensors();
                let actuators = side.peer.tick(&sensors);
                side.plant.step(time_s, &actuators);
                let peer = &mut *side.peer;
                each(Seen { number: index + 1, exchanged, sensors: &sensors, actuators: &actuators, peer });
            }
        }
    }

    /// The fault that stopped either peer, if any, with the peer's number (1 or 2).
    pub fn fault(&self) -> Option<(usize, Fault)> {
        self.sides.iter().enumerate().find_map(|(index, side)| match side.peer.mode() {
            Mode::Faulted(fault) => Some((index + 1, fault)),
            _ => None,
        })
    }

    /// A hash (FNV-1a over 64-bit words) of the bits of both peers' dynamic states, continued from `seed`.
    pub fn hash(&self, seed: u64) -> u64 {
        self.sides.iter().fold(seed, |hash, side| side.peer.hash(hash))
    }
}

/// Where [`Pair::hash`] starts.
pub const HASH_SEED: u64 = 0xcbf2_9ce4_8422_2325;
