//! One peer in real time: a [`Node`] on a UDP socket, at a 1 kHz beat from the operating system.
//!
//! At every beat the socket is emptied, then the node ticks: what was heard in a packet period goes into the exchange at its
//! end, newest flow only. Emptying stops half a period after the beat began, so that no flood of datagrams, forged or not,
//! can hold up the tick; what is left waits for the next beat or is dropped by the system, as on any full line.

use haptic_sim::key_file::entropy;
use std::net::SocketAddr;
use std::time::{Duration, Instant};

use haptic_core::safety::Mode;
use haptic_protocol::key::Key;
use haptic_protocol::link::{Notice, Stage};
use haptic_protocol::wire::Telemetry;
use serde::Serialize;

use super::pace::{Pace, Punctuality};
use super::socket::{drain, open};
use haptic_sim::node::Node;
use haptic_sim::scene::Scene;

/// Where and how long.
#[derive(Clone, Debug)]
pub struct Options {
    /// 1 (left) or 2 (right).
    pub number: u8,
    /// Where this peer listens.
    pub listen: SocketAddr,
    /// Where the other one does.
    pub connect: SocketAddr,
    /// Time of the experiment once both are there, s.
    pub duration_s: f64,
    /// How long to call before giving up, s.
    pub patience_s: f64,
}

/// What one peer saw.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// 1 or 2.
    pub peer: u8,
    /// Ticks while armed.
    pub ticks: u64,
    /// Mean |x_o − x_d| over the last half, mm.
    pub decoded_discrepancy_mm: f64,
    /// Mean F_T over the last half, N.
    pub coordination_force_n: f64,
    /// Why it stopped, if it did.
    pub fault: Option<String>,
    /// What the link reported, in order, with the time in s since the start.
    pub notices: Vec<(f64, String)>,
    /// Round trip, µs.
    pub round_trip_us: Option<u32>,
    /// Jitter of the round trip, µs.
    pub jitter_us: u32,
    /// The other peer's clock less this one's, µs.
    pub clock_offset_us: Option<i64>,
    /// How much faster the other peer's clock runs, ppm.
    pub clock_drift_ppm: f32,
    /// What the other peer last said about itself.
    pub other: Option<Other>,
    /// Datagrams taken.
    pub datagrams_taken: u32,
    /// Datagrams of the other peer that never came.
    pub datagrams_missing: u32,
    /// Datagrams refused: forged, replayed or broken.
    pub datagrams_refused: u32,
    /// How well the 1 kHz beat was kept.
    pub punctuality: Punctuality,
}

/// What the other peer's telemetry says.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Other {
    /// Its ticks so far.
    pub ticks: u32,
    /// 0 disarmed, 1 armed, 2 faulted.
    pub mode: u8,
    /// Its fault's number, 0 none.
    pub fault: u8,
    /// Its coordination force, N.
    pub coordination_force_n: f32,
    /// The round trip as it measures it, µs.
    pub round_trip_us: u32,
    /// Energy that it took from the network, J.
    pub energy_received_j: f64,
    /// Energy that it gave to the network, J.
    pub energy_sent_j: f64,
}

impl Other {
    pub(super) fn new(said: &Telemetry) -> Self {
        Self {
            ticks: said.tick,
            mode: said.mode,
            fault: said.fault,
            coordination_force_n: said.coordination_force,
            round_trip_us: said.round_trip_us,
            energy_received_j: said.energy_received,
            energy_sent_j: said.energy_sent,
        }
    }
}

/// Runs one peer to the end of its experiment.
///
/// # Errors
/// A scene or key that is refused, a socket that cannot be opened, or nobody answering: in one line.
pub fn run(scene: &Scene, key: Key, options: &Options) -> Result<Report, String> {
    let mut node = Node::new(scene, options.number, key, entropy()?)?;
    let socket = open(options.listen)?;
    let period_s = scene.peer.timing.control_period_s;
    let period = Duration::from_secs_f64(period_s);
    let ticks = (options.duration_s / period_s).round() as u64;
    let mut pace = Pace::new(period);
    let (mut discrepancy, mut force, mut counted) = (0.0, 0.0, 0_u64);
    while node.armed_ticks() < ticks {
        pace.wait();
        let now_us = pace.now_us();
        // What is refused is counted by the link, and there is nothing else to do about it.
        drain(&socket, Instant::now() + period / 2, |_, datagram| {
            let _ = node.receive(now_us, datagram);
        });
        // A datagram that the socket does not take now is late, and late flow is worth nothing.
        node.beat(now_us, |bytes| {
            let _ = socket.send_to(bytes, options.connect);
        });
        if let Some(table) = node.link().refused() {
            return Err(format!("the other peer was told other parameters: table [{table}] of the scene differs"));
        }
        if node.mode() == Mode::Disarmed && now_us as f64 * 1e-6 > options.patience_s {
            let Options { connect, patience_s, .. } = options;
            return Err(match node.link().stage() {
                Stage::Idle | Stage::Running | Stage::Fading => format!(
                    "{connect} is there, but sent no flow within {patience_s} s: a hub waits until all its peers are there"
                ),
                _ => format!("nobody answered from {connect} within {patience_s} s"),
            });
        }
        if node.armed_ticks() > ticks / 2 {
            let seen = node.observed();
            discrepancy += f64::from((seen.object.position - seen.desired.position).abs());
            force += f64::from(seen.coordination_force);
            counted += 1;
        }
    }
    let (link, counts) = (node.link(), node.link().counts());
    let told = |(at_us, notice): &(u64, Notice)| (*at_us as f64 * 1e-6, format!("{notice:?}"));
    Ok(Report {
        peer: options.number,
        ticks: node.armed_ticks(),
        decoded_discrepancy_mm: 1e3 * discrepancy / counted.max(1) as f64,
        coordination_force_n: force / counted.max(1) as f64,
        fault: match node.mode() {
            Mode::Faulted(fault) => Some(format!("fault {}: {}", fault.number(), fault.explain())),
            _ => None,
        },
        notices: node.notices().iter().map(told).collect(),
        round_trip_us: link.clock().round_trip_us(),
        jitter_us: link.clock().jitter_us(),
        clock_offset_us: link.clock().offset_us(pace.now_us()),
        clock_drift_ppm: link.clock().drift_ppm(),
        other: node.heard().map(Other::new),
        datagrams_taken: counts.taken,
        datagrams_missing: counts.missing,
        datagrams_refused: counts.refused,
        punctuality: pace.punctuality(),
    })
}
