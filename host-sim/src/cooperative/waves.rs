//! N peers of the wave kind and one object: every peer has its copy, every wave goes to the server's lossless node
//! ([`haptic_core::couple::node`]) and what the node scatters comes back.
//!
//! The peers are the ones of `cooperate`, copy and all; only what their packets pass through differs. With two users of equal
//! impedance the node joins the two lines: then this is the plain pair whose one-way delay is the way up and the way down.
//! Constant delay without loss only: a wave held through a loss is not the line's.

use haptic_core::couple::node::Node;
use haptic_core::couple::{Packet, Sends, sends};
use haptic_core::motion::Motion;
use haptic_core::peer::{self, State};
use haptic_core::safety::{Command, Mode};
use haptic_core::scene::{Any, Scene};
use haptic_core::settings::Refused;
use serde::Serialize;

use super::MOST_USERS;
use super::world::WorldError;
use crate::network::Way;
use crate::network::fate::Direction;
use crate::plant::Plant;
use crate::scene::{Network, SceneFile};

/// One peer, its device and its lines to and from the server.
#[derive(Clone, Debug)]
struct Seat {
    scene: Scene<Any<f64>>,
    state: State<Any<f64>>,
    plant: Plant,
    up: Way<f64>,
    down: Way<f64>,
    /// The wave that last came out of the line at the server, √W.
    at_node: f64,
}

/// Peers around a node.
#[derive(Clone, Debug)]
pub struct Waves {
    seats: Vec<Seat>,
    node: Node<f64, MOST_USERS>,
    period_s: f64,
    ticks_per_packet: u64,
    tick: u64,
    /// Wave energy into and out of the node, J.
    energy_j: [f64; 2],
}

/// What a run gave.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Outcome {
    /// Nobody stopped.
    pub stable: bool,
    /// Mean over the last half of the largest distance between two copies at one instant, mm.
    pub true_discrepancy_mm: f64,
    /// Mean |contact force|, N.
    pub felt_n: f64,
    /// Largest |contact force|, N.
    pub peak_n: f64,
    /// Wave energy out of the node over energy into it.
    pub node_out_over_in: f64,
}

impl Waves {
    /// `users` peers in this scene, armed and at rest; the scene's delay is the way between a peer and the server.
    ///
    /// # Errors
    /// Users out of range; a comm that sends no waves; a network that does more than delay; what the peers refuse.
    pub fn new(scene: &SceneFile, users: usize) -> Result<Self, WorldError> {
        if !(1..=MOST_USERS).contains(&users) {
            return Err(WorldError::Users(users));
        }
        let network = scene.world.network;
        let plain = Network {
            one_way_delay_packets: network.one_way_delay_packets,
            extra_delay_s: network.extra_delay_s,
            asymmetry_s: network.asymmetry_s,
            seed: network.seed,
            ..Network::default()
        };
        if network != plain || scene.network_trace.is_some() {
            return Err(WorldError::NotConstant);
        }
        if sends(&scene.peer) != Sends::Waves || scene.peer.coordination.ledger {
            return Err(WorldError::NoWaves);
        }
        let settings = scene.peers();
        let seat = |index: usize| -> Result<Seat, Refused<'static>> {
            let built = Scene::build(&settings[index % 2])?;
            let plant = Plant::new(scene, index % 2);
            let start = plant.motions().map(|motion| Motion::at(motion.position));
            let mut state = State::new(&built, start);
            state.command(&built, Command::Arm);
            let (up, down) = (Way::new(scene, Direction::OneToTwo), Way::new(scene, Direction::TwoToOne));
            Ok(Seat { scene: built, state, plant, up, down, at_node: 0.0 })
        };
        let seats = (0..users).map(seat).collect::<Result<Vec<_>, _>>()?;
        let impedance = scene.peer.coordination.wave_impedance_n_s_per_m;
        Ok(Self {
            node: Node::new(core::array::from_fn(|index| if index < users { impedance } else { 0.0 })),
            seats,
            period_s: scene.peer.timing.control_period_s,
            ticks_per_packet: u64::from(scene.peer.timing.ticks_per_packet),
            tick: 0,
            energy_j: [0.0; 2],
        })
    }

    /// The object's copy at every peer, as the last tick saw it.
    pub fn copies(&self) -> impl Iterator<Item = Motion<f64>> {
        self.seats.iter().map(|seat| seat.state.observed().object)
    }

    /// Contact force at every peer, N.
    pub fn forces(&self) -> impl Iterator<Item = f64> {
        self.seats.iter().map(|seat| seat.state.observed().contact_force)
    }

    /// One tick.
    pub fn step(&mut self) {
        if self.tick.is_multiple_of(self.ticks_per_packet) {
            self.exchange((self.tick / self.ticks_per_packet) as f64);
        }
        let time_s = self.period_s * self.tick as f64;
        for seat in &mut self.seats {
            let sensors = seat.plant.sensors();
            let actuators = peer::tick(&seat.scene, &mut seat.state, &sensors);
            seat.plant.step(time_s, &actuators);
        }
        self.tick += 1;
    }

    /// Packets to the server, through the node, and back.
    fn exchange(&mut self, time: f64) {
        let mut waves = [0.0; MOST_USERS];
        for (seat, wave) in self.seats.iter_mut().zip(&mut waves) {
            seat.up.send(time, peer::outgoing(&seat.scene, &seat.state).wave);
            seat.at_node = seat.up.take(time).unwrap_or(seat.at_node);
            *wave = seat.at_node;
        }
        let scattered = self.node.scatter(waves).back;
        let energy = |waves: [f64; MOST_USERS]| -> f64 { waves.iter().map(|wave| 0.5 * wave * wave).sum() };
        let packet_s = self.period_s * self.ticks_per_packet as f64;
        self.energy_j[0] += packet_s * energy(waves);
        self.energy_j[1] += packet_s * energy(scattered);
        for (seat, wave) in self.seats.iter_mut().zip(scattered) {
            seat.down.send(time, wave);
            let incoming = seat.down.take(time).map(|wave| Packet { wave, ..Packet::default() });
            peer::exchange(&seat.scene, &mut seat.state, incoming);
        }
    }

    /// Runs on for `duration_s`.
    pub fn run(&mut self, duration_s: f64) -> Outcome {
        let ticks = (duration_s / self.period_s).round() as u64;
        let (mut discrepancy, mut felt, mut counted, mut peak_n) = (0.0, 0.0, 0_u64, 0.0_f64);
        for tick in 0..ticks {
            self.step();
            peak_n = self.forces().map(f64::abs).fold(peak_n, f64::max);
            if tick >= ticks / 2 {
                counted += 1;
                let places = || self.copies().map(|copy| copy.position);
                discrepancy += places().fold(f64::NEG_INFINITY, f64::max) - places().fold(f64::INFINITY, f64::min);
                felt += self.forces().map(f64::abs).sum::<f64>() / self.seats.len() as f64;
            }
        }
        let [into, out] = self.energy_j;
        Outcome {
            stable: self.seats.iter().all(|seat| seat.state.mode() == Mode::Armed),
            true_discrepancy_mm: 1e3 * discrepancy / counted.max(1) as f64,
            felt_n: felt / counted.max(1) as f64,
            peak_n,
            node_out_over_in: if into > 0.0 { out / into } else { 1.0 },
        }
    }
}
