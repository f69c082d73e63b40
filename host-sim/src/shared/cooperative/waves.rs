//! N peers of the wave kind and one object: every peer has its copy, every wave goes to the server, where the lines meet
//! ([`super::junction`]), and what is scattered there comes back.
//!
//! The peers are the ones of `cooperate`, copy and all; only what their packets pass through differs. With two users of equal
//! impedance the node joins the two lines: then this is the plain pair whose one-way delay is the way up and the way down.
//! Constant delay without loss only, unless `coordination.ledger` pays for what is held.

use haptic_core::law::Packet;
use haptic_core::num::Motion;
use haptic_core::safety::{Command, Mode};
use haptic_core::settings::Refused;
use serde::Serialize;

use super::MOST_USERS;
use super::junction::Junction;
use super::world::WorldError;
use haptic_sim::measure::LastHalf;
use haptic_sim::network::Way;
use haptic_sim::network::rule::Direction;
use haptic_sim::peers::DynPeer;
use haptic_sim::plant::Plant;
use haptic_sim::scene::{Network, Scene};

/// One peer, its device and its lines to and from the server.
struct Seat {
    peer: Box<dyn DynPeer<f64>>,
    plant: Plant,
    up: Way<Packet<f64>>,
    down: Way<Packet<f64>>,
}

/// Peers around a node.
pub struct Waves {
    seats: Vec<Seat>,
    junction: Junction,
    period_s: f64,
    ticks_per_packet: u64,
    tick: u64,
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
    /// Wave energy out of the node over what the peers put into their lines, as far as the node heard of it.
    pub node_out_over_put_in: f64,
}

impl Waves {
    /// `users` peers in this scene, armed and at rest; the scene's delay is the way between a peer and the server.
    ///
    /// # Errors
    /// Users out of range; a comm that sends no waves; a network that does more than delay, without the ledger; what the
    /// peers refuse.
    pub fn new(scene: &Scene, users: usize) -> Result<Self, WorldError> {
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
        if (network != plain || scene.network_trace.is_some()) && !scene.peer.coordination.ledger {
            return Err(WorldError::NotConstant);
        }
        let junction = Junction::new(&scene.peer, users)?;
        let seat = |index: usize| -> Result<Seat, Refused<'static>> {
            let mut peer = scene.peer(index % 2)?;
            peer.command(Command::Arm);
            let way = |direction| Way::new(scene, direction, index as u32);
            let (up, down) = (way(Direction::OneToTwo), way(Direction::TwoToOne));
            Ok(Seat { peer, plant: Plant::new(scene, index % 2), up, down })
        };
        let seats = (0..users).map(seat).collect::<Result<Vec<_>, _>>()?;
        Ok(Self {
            junction,
            seats,
            period_s: scene.peer.timing.control_period_s,
            ticks_per_packet: u64::from(scene.peer.timing.ticks_per_packet),
            tick: 0,
        })
    }

    /// The object's copy at every peer, as the last tick saw it.
    pub fn copies(&self) -> impl Iterator<Item = Motion<f64>> {
        self.seats.iter().map(|seat| seat.peer.observed().object)
    }

    /// Contact force at every peer, N.
    pub fn forces(&self) -> impl Iterator<Item = f64> {
        self.seats.iter().map(|seat| seat.peer.observed().contact_force)
    }

    /// One tick.
    pub fn step(&mut self) {
        if self.tick.is_multiple_of(self.ticks_per_packet) {
            self.exchange((self.tick / self.ticks_per_packet) as f64);
        }
        let time_s = self.period_s * self.tick as f64;
        for seat in &mut self.seats {
            let sensors = seat.plant.sensors();
            let actuators = seat.peer.tick(&sensors);
            seat.plant.step(time_s, &actuators);
        }
        self.tick += 1;
    }

    /// Packets to the server, through the junction, and back.
    fn exchange(&mut self, time: f64) {
        self.junction.exchange(self.seats.iter_mut().map(|seat| {
            seat.up.send(time, seat.peer.outgoing());
            seat.up.take(time)
        }));
        for (seat, port) in self.seats.iter_mut().zip(self.junction.ports()) {
            seat.down.send(time, port.back);
            let incoming = seat.down.take(time);
            seat.peer.exchange(incoming);
        }
    }

    /// Runs on for `duration_s`.
    pub fn run(&mut self, duration_s: f64) -> Outcome {
        let ticks = (duration_s / self.period_s).round() as u64;
        let (mut halves, mut peak_n) = (LastHalf::new(ticks), 0.0_f64);
        for tick in 0..ticks {
            self.step();
            peak_n = self.forces().map(f64::abs).fold(peak_n, f64::max);
            let places = || self.copies().map(|copy| copy.position);
            let apart_m = places().fold(f64::NEG_INFINITY, f64::max) - places().fold(f64::INFINITY, f64::min);
            halves.see(tick, [apart_m, self.forces().map(f64::abs).sum::<f64>() / self.seats.len() as f64]);
        }
        let [discrepancy_m, felt_n] = halves.means();
        let energy = self.junction.energy();
        let out_over = |into: f64| if into > 0.0 { energy.sent_j / into } else { 1.0 };
        Outcome {
            stable: self.seats.iter().all(|seat| seat.peer.mode() == Mode::Armed),
            true_discrepancy_mm: 1e3 * discrepancy_m,
            felt_n,
            peak_n,
            node_out_over_in: out_over(energy.taken_j),
            node_out_over_put_in: out_over(energy.put_in_j),
        }
    }
}
