//! Two peers, two devices and a network, stepped together.
//!
//! The harness does for a simulated device what the board's interrupt does for a real one: read, tick, command, and a
//! packet every M ticks. Time and randomness are arguments, so a run is a function of its scene: the same bits on every
//! machine and any number of threads ([`Harness::hash`]).

use haptic_core::law::Packet;
use haptic_core::num::{Scalar, StateVector};
use haptic_core::peer::{self, Actuators, Sensors, State};
use haptic_core::safety::{Command, Fault, Mode};
use haptic_core::scene::{Any, Models, Scene};
use haptic_core::settings::Refused;

use crate::network::Way;
use crate::network::rule::Direction;
use crate::plant::Plant;
use crate::scene::SceneFile;

/// One peer with its device and the line that its packets come in by.
#[derive(Clone, Debug)]
pub struct Side<M: Models> {
    /// What the peer knows.
    pub scene: Scene<M>,
    /// What of it changes.
    pub state: State<M>,
    /// Its device and user.
    pub plant: Plant,
    /// The network from the other peer to this one.
    pub incoming: Way<Packet<M::Scalar>>,
}

/// What a tick of a peer read and did.
#[derive(Debug)]
pub struct Seen<'a, M: Models> {
    /// Which peer, 1 or 2.
    pub number: usize,
    /// The exchange before the tick, if one was due, with what it took in.
    pub exchanged: Option<Option<Packet<M::Scalar>>>,
    /// What the tick read.
    pub sensors: &'a Sensors<M::Scalar>,
    /// What it commanded.
    pub actuators: &'a Actuators<M::Scalar>,
    /// The state that it left.
    pub state: &'a mut State<M>,
}

/// Two peers on one network.
#[derive(Clone, Debug)]
pub struct Harness<M: Models> {
    /// Peer 1 (left) and peer 2 (right).
    pub sides: [Side<M>; 2],
    period_s: f64,
    tick: u64,
    /// Ticks in a packet period.
    ticks_per_packet: f64,
    /// Peer 2's control period over the true one.
    drift: f64,
}

/// The pair with models chosen by the scene, computing in `S`.
pub type Pair<S> = Harness<Any<S>>;

impl<M: Models> Harness<M> {
    /// Both peers armed and at rest.
    ///
    /// # Errors
    /// What [`Scene::build`] refuses.
    pub fn new(file: &SceneFile) -> Result<Self, Refused<'static>> {
        let [left, right] = file.peers();
        let side = |index: usize, settings| {
            let scene = Scene::<M>::build(settings)?;
            let plant = Plant::new(file, index);
            let device = plant.motions().map(|motion| haptic_core::num::Motion {
                position: M::Scalar::from_f64(motion.position),
                velocity: M::Scalar::ZERO,
            });
            let mut state = State::new(&scene, device);
            state.command(&scene, Command::Arm);
            let incoming = Way::new(file, if index == 0 { Direction::TwoToOne } else { Direction::OneToTwo });
            Ok(Side { scene, state, plant, incoming })
        };
        Ok(Self {
            sides: [side(0, &left)?, side(1, &right)?],
            period_s: file.peer.timing.control_period_s,
            tick: 0,
            ticks_per_packet: f64::from(file.peer.timing.ticks_per_packet),
            drift: 1.0 + 1e-6 * file.world.network.clock_drift_ppm,
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
    pub fn step_watched(&mut self, each: &mut impl FnMut(Seen<'_, M>)) {
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
    fn round(&mut self, turns: [bool; 2], each: &mut impl FnMut(Seen<'_, M>)) {
        let (time_s, now) = (self.time_s(), self.tick as f64 / self.ticks_per_packet);
        let [left, right] = &mut self.sides;
        let [left_due, right_due] = [turns[0] && left.state.packet_due(), turns[1] && right.state.packet_due()];
        // Both packets are made before either is taken in: a network without delay delivers within the tick.
        if left_due {
            right.incoming.send(now, peer::outgoing(&left.scene, &left.state));
        }
        if right_due {
            left.incoming.send(now, peer::outgoing(&right.scene, &right.state));
        }
        let exchanged = [(&mut *left, left_due), (&mut *right, right_due)].map(|(side, due)| {
            due.then(|| {
                let incoming = side.incoming.take(now);
                peer::exchange(&side.scene, &mut side.state, incoming);
                incoming
            })
        });
        for (index, (side, exchanged)) in [left, right].into_iter().zip(exchanged).enumerate() {
            if turns[index] {
                let sensors = side.plant.sensors();
                let actuators = peer::tick(&side.scene, &mut side.state, &sensors);
                side.plant.step(time_s, &actuators);
                let state = &mut side.state;
                each(Seen { number: index + 1, exchanged, sensors: &sensors, actuators: &actuators, state });
            }
        }
    }

    /// The fault that stopped either peer, if any, with the peer's number (1 or 2).
    pub fn fault(&self) -> Option<(usize, Fault)> {
        self.sides.iter().enumerate().find_map(|(index, side)| match side.state.mode() {
            Mode::Faulted(fault) => Some((index + 1, fault)),
            _ => None,
        })
    }

    /// A hash (FNV-1a over 64-bit words) of the bits of both peers' dynamic states, continued from `seed`.
    pub fn hash(&self, seed: u64) -> u64 {
        let mut hash = seed;
        for side in &self.sides {
            let mut state = side.state;
            state.visit(&mut |number: &mut M::Scalar| {
                // The fold brings the high bits down, where the next product spreads them again.
                hash = (hash ^ number.bits()).wrapping_mul(0x0000_0100_0000_01b3);
                hash ^= hash >> 32;
            });
        }
        hash
    }
}

/// Where [`Harness::hash`] starts.
pub const HASH_SEED: u64 = 0xcbf2_9ce4_8422_2325;
