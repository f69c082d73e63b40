//! N peers of the wave kind and one object: every peer has its copy, every wave goes to the server, where the lines meet
//! ([`super::junction`]), and what is scattered there comes back.
//!
//! The peers are the ones of `cooperate`, copy and all; only what their packets pass through differs. With two users of equal
//! impedance the node joins the two lines: then this is the plain pair whose one-way delay is the way up and the way down.
//! Constant delay without loss only, unless `coordination.ledger` pays for what is held, or the lines have a time of their own.

use cohold_core::law::Packet;
use cohold_core::{num::Motion, safety::Mode};
use cohold_sim::engine::{Actor, Engine, Out, Seat};
use cohold_sim::network::link::{Inbox, Numbered, Route};
use cohold_sim::scene::{Network, Scene};
use cohold_sim::{measure::LastHalf, network::rule::Direction, pair::Side, plant::Plant};
use serde::Serialize;

use super::{MOST_USERS, junction::Junction};
use crate::Error;

/// Who sits at the engine: first the server, where the lines meet.
#[expect(clippy::large_enum_variant, reason = "at most seventeen of them")]
enum Around {
    Server(JunctionServer),
    Peer(Side<f64>),
}

/// The server's ends of the lines, and where they meet.
struct JunctionServer {
    junction: Junction,
    lines: Vec<Inbox<[Packet<f64>; 1]>>,
    packet_ns: u64,
}

impl Actor<usize> for Around {
    type Packet = Numbered<[Packet<f64>; 1]>;

    fn hear(&mut self, now_ns: u64, from: usize, packet: &mut Self::Packet, out: &mut Out<'_, usize, Self::Packet>) {
        match self {
            Self::Server(junction_server) => junction_server.lines[from - 1].put(now_ns, *packet),
            Self::Peer(side) => side.hear(now_ns, from, packet, out),
        }
    }

    fn speak(&mut self, now_ns: u64, out: &mut Out<'_, usize, Self::Packet>) {
        if let Self::Peer(side) = self {
            side.speak(now_ns, out);
        }
    }

    fn act(&mut self, now_ns: u64, out: &mut Out<'_, usize, Self::Packet>) {
        match self {
            Self::Peer(side) => side.act(now_ns, out),
            Self::Server(JunctionServer { junction, lines, packet_ns }) => {
                let packets_due = now_ns.is_multiple_of(*packet_ns);
                if junction.is_due(packets_due) {
                    junction.exchange(lines.iter_mut().map(|line| line.take(now_ns).copied()), packets_due);
                }
                for (port, to) in junction.ports.iter().zip(1..).filter(|_| packets_due) {
                    out(to, &Numbered::new(now_ns / *packet_ns, port.back()));
                }
            }
        }
    }
}

/// Peers around a node.
pub struct Waves {
    engine: Engine<Around>,
    period_s: f64,
}

/// What a run gave.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Outcome {
    /// Whether no peer stopped with a fault.
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
    /// A scene or a number of users that cannot be built.
    pub fn new(scene: &Scene, users: usize) -> Result<Self, Error> {
        if !(1..=MOST_USERS).contains(&users) {
            return Err(Error::Users(users));
        }
        let network = scene.world.network;
        let plain = Network {
            one_way_delay_packets: network.one_way_delay_packets,
            extra_delay_s: network.extra_delay_s,
            asymmetry_s: network.asymmetry_s,
            seed: network.seed,
            ..Network::default()
        };
        let waves_unpaid = scene.law().scatters && !scene.peer.coordination.ledger;
        if (network != plain || scene.network_trace.is_some()) && waves_unpaid {
            return Err(Error::NotConstant);
        }
        let junction = Junction::new(scene, users)?;
        let timing = &scene.peer.timing;
        let every = if junction.is_due(false) { 1 } else { timing.ticks_per_packet };
        let lines = (0..users).map(|_| Inbox::new(scene, every)).collect();
        let server = Around::Server(JunctionServer { junction, lines, packet_ns: timing.packet_period_ns() });
        let peers = (0..users).map(|index| {
            let end = index % 2;
            Ok(Seat::new(Around::Peer(Side::new(scene, end, 0, Plant::new(scene, end))?)))
        });
        let seats = std::iter::once(Ok(Seat::new(server))).chain(peers).collect::<Result<_, Error>>()?;
        let route = |from: usize, to: usize| match from {
            0 => Route::of_scene(scene, Direction::TwoToOne, to.saturating_sub(1) as u32),
            _ => Route::of_scene(scene, Direction::OneToTwo, from as u32 - 1),
        };
        Ok(Self { engine: Engine::new(timing.control_period_ns(), seats, route), period_s: timing.control_period_s })
    }

    /// The peers, in order.
    pub fn sides(&self) -> impl Iterator<Item = &Side<f64>> {
        self.engine.seats.iter().filter_map(|seat| match &seat.actor {
            Around::Peer(side) => Some(side),
            Around::Server(_) => None,
        })
    }

    /// Where the lines meet.
    ///
    /// # Panics
    /// Never: there is a server.
    pub fn junction(&self) -> &Junction {
        let junction = self.engine.seats.iter().find_map(|seat| match &seat.actor {
            Around::Server(server) => Some(&server.junction),
            Around::Peer(_) => None,
        });
        junction.expect("a server")
    }

    /// The peers, to be changed.
    pub fn sides_mut(&mut self) -> impl Iterator<Item = &mut Side<f64>> {
        self.engine.seats.iter_mut().filter_map(|seat| match &mut seat.actor {
            Around::Peer(side) => Some(side),
            Around::Server(_) => None,
        })
    }

    /// The network from seat to seat, of which the first is the server's.
    pub fn route(&mut self, from: usize, to: usize) -> &mut Route {
        self.engine.route(from, to)
    }

    /// The object's copy at every peer, as the last tick saw it.
    pub fn copies(&self) -> impl Iterator<Item = Motion<f64>> {
        self.sides().map(|side| side.peer.observed()[0].object)
    }

    /// Contact force at every peer, N.
    pub fn forces(&self) -> impl Iterator<Item = f64> {
        self.sides().map(|side| side.peer.observed()[0].contact_force)
    }

    /// Steps peers and server by one tick.
    pub fn step(&mut self) {
        self.engine.step(&mut |_| ());
    }

    /// Runs on for `duration_s`.
    pub fn run(&mut self, duration_s: f64) -> Outcome {
        let ticks = (duration_s / self.period_s).round() as u64;
        let (mut means, mut peak_n) = (LastHalf::new(ticks), 0.0_f64);
        for tick in 0..ticks {
            self.step();
            peak_n = self.forces().map(f64::abs).fold(peak_n, f64::max);
            let places = || self.copies().map(|copy| copy.position);
            let distance_m = places().fold(f64::NEG_INFINITY, f64::max) - places().fold(f64::INFINITY, f64::min);
            means.see(tick, [distance_m, self.forces().map(f64::abs).sum::<f64>() / self.sides().count() as f64]);
        }
        let energy = self.junction().energy();
        let [discrepancy, felt_n] = means.means();
        let out_over = |into: f64| if into > 0.0 { energy.sent_j / into } else { 1.0 };
        Outcome {
            stable: self.sides().all(|side| side.peer.mode() == Mode::Armed),
            true_discrepancy_mm: 1e3 * discrepancy,
            felt_n,
            peak_n,
            node_out_over_in: out_over(energy.taken_j),
            node_out_over_put_in: out_over(energy.put_in_j),
        }
    }
}
