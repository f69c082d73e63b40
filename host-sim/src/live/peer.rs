//! One peer in real time: the tick and exchange that fly, a simulated device in a simulated hand, a sealed link.
//!
//! The peer calls until the other one is heard, arms, and runs the scene's user from there for the asked duration. What
//! was heard in a packet period goes into the exchange at its end, newest flow only. Peers compute in f32, as the board.

use std::net::{SocketAddr, UdpSocket};
use std::time::Duration;

use haptic_core::couple::Packet;
use haptic_core::motion::Motion;
use haptic_core::peer::{self, State};
use haptic_core::safety::{Command, Mode};
use haptic_core::scene::{Any, Scene};
use haptic_core::settings::{Settings, Value};
use haptic_protocol::ends::Ends;
use haptic_protocol::key::Key;
use haptic_protocol::link::{Config, Incoming, Link, Notice};
use haptic_protocol::parameters::{Parameters, Table};
use haptic_protocol::wire::{Flow, MAX_DATAGRAM, PeerId};
use serde::Serialize;

use super::pace::{Pace, Punctuality};
use crate::plant::Plant;
use crate::scene::SceneFile;

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
    /// Datagrams taken.
    pub datagrams_taken: u32,
    /// Datagrams of the other peer that never came.
    pub datagrams_missing: u32,
    /// Datagrams refused: forged, replayed or broken.
    pub datagrams_refused: u32,
    /// How well the 1 kHz beat was kept.
    pub punctuality: Punctuality,
}

/// Tables that both peers must have been told alike; the rest is each device's own.
const SHARED_TABLES: [&str; 3] = ["timing", "object", "coordination"];

fn parameters(settings: &Settings) -> Result<Parameters, String> {
    let mut parameters = Parameters::new();
    for name in SHARED_TABLES {
        let mut table = Table::new(name);
        for key in Settings::KEYS {
            let Some((_, short)) = key.name.split_once('.').filter(|(table, _)| *table == name) else { continue };
            table = match settings.get(key.name) {
                Some(Value::Number(number)) => table.number(short, number),
                Some(Value::Flag(flag)) => table.flag(short, flag),
                Some(Value::Text(text)) => table.text(short, text),
                None => table,
            };
        }
        parameters.add(table).map_err(|error| format!("{error:?}"))?;
    }
    Ok(parameters)
}

fn flow_of(packet: Packet<f32>, engaged: bool, tick: u64) -> Flow {
    Flow {
        engaged,
        tick: tick as u32,
        position: packet.motion.position,
        velocity: packet.motion.velocity,
        wave: packet.wave,
        wave_integral: packet.wave_integral,
        energy_sent: packet.energy_j,
        ..Flow::default()
    }
}

fn packet_of(flow: &Flow) -> Packet<f32> {
    Packet {
        motion: Motion { position: flow.position, velocity: flow.velocity },
        wave: flow.wave,
        energy_j: flow.energy_sent,
        wave_integral: flow.wave_integral,
    }
}

/// Runs one peer to the end of its experiment.
///
/// # Errors
/// A scene or key that is refused, a socket that cannot be opened, or nobody answering: in one line.
pub fn run(scene: &SceneFile, key: Key, options: &Options) -> Result<Report, String> {
    let index = usize::from(options.number == 2);
    let settings = &scene.peers()[index];
    let built = Scene::<Any<f32>>::build(settings).map_err(|refused| refused.to_string())?;
    let mut plant = Plant::new(scene, index);
    let start = plant.motions().map(|motion| Motion::at(motion.position as f32));
    let mut state = State::new(&built, start);

    let socket =
        UdpSocket::bind(options.listen).map_err(|cause| format!("cannot listen on {}: {cause}", options.listen))?;
    socket.set_nonblocking(true).map_err(|cause| format!("cannot poll the socket: {cause}"))?;
    let mut entropy = [0; Key::LEN];
    getrandom::fill(&mut entropy).map_err(|cause| format!("no randomness: {cause}"))?;
    let period_s = settings.timing.control_period_s;
    let mut link = Link::new(Config {
        key,
        ends: Ends { local: PeerId(options.number), remote: PeerId(3 - options.number) },
        packet_period_us: (1e6 * period_s * f64::from(settings.timing.ticks_per_packet)) as u32,
        parameters: parameters(settings)?,
        entropy,
    })
    .map_err(|error| error.to_string())?;

    let ticks = (options.duration_s / period_s).round() as u64;
    let mut pace = Pace::new(Duration::from_secs_f64(period_s));
    let (mut out, mut came) = ([0; MAX_DATAGRAM], [0; 2048]);
    let (mut newest, mut armed_ticks, mut waiting) = (None, 0_u64, 0_u64);
    let (mut discrepancy, mut force, mut counted) = (0.0, 0.0, 0_u64);
    let mut notices = Vec::new();
    // A datagram that the socket does not take now is late, and late flow is worth nothing.
    let send = |bytes: &[u8]| drop(socket.send_to(bytes, options.connect));
    while armed_ticks < ticks {
        pace.wait();
        let now = pace.now_us();
        while let Ok((len, _)) = socket.recv_from(&mut came) {
            if let Ok(Some(Incoming::Flow(flow))) = link.receive(now, &mut came[..len]) {
                newest = Some(flow);
            }
        }
        while let Some(notice) = link.take_notice() {
            if let Notice::Refused { table } = notice {
                return Err(format!("the other peer was told other parameters: table [{table}] of the scene differs"));
            }
            notices.push((now as f64 * 1e-6, format!("{notice:?}")));
        }
        if state.mode() == Mode::Disarmed && newest.is_some() {
            state.command(&built, Command::Arm);
        }
        if state.packet_due() {
            let incoming = newest.take().filter(|flow| flow.engaged).map(|flow| packet_of(&flow));
            let packet = peer::exchange(&built, &mut state, incoming);
            let flow = flow_of(packet, state.mode() == Mode::Armed, armed_ticks);
            if let Some(len) = link.send_flow(now, &flow, &mut out) {
                send(&out[..len]);
            }
        }
        while let Some(len) = link.poll(now, &mut out) {
            send(&out[..len]);
        }
        let actuators = peer::tick(&built, &mut state, &plant.sensors());
        if state.mode() == Mode::Disarmed {
            waiting += 1;
            if waiting as f64 * period_s > options.patience_s {
                return Err(format!("nobody answered from {} within {} s", options.connect, options.patience_s));
            }
            continue;
        }
        plant.step(armed_ticks as f64 * period_s, &actuators);
        armed_ticks += 1;
        if armed_ticks > ticks / 2 {
            let seen = state.observed();
            discrepancy += f64::from((seen.object.position - seen.desired.position).abs());
            force += f64::from(seen.coordination_force);
            counted += 1;
        }
    }
    let counts = link.counts();
    Ok(Report {
        peer: options.number,
        ticks: armed_ticks,
        decoded_discrepancy_mm: 1e3 * discrepancy / counted.max(1) as f64,
        coordination_force_n: force / counted.max(1) as f64,
        fault: match state.mode() {
            Mode::Faulted(fault) => Some(format!("fault {}: {}", fault.number(), fault.explain())),
            _ => None,
        },
        notices,
        round_trip_us: link.clock().round_trip_us(),
        jitter_us: link.clock().jitter_us(),
        datagrams_taken: counts.taken,
        datagrams_missing: counts.missing,
        datagrams_refused: counts.refused,
        punctuality: pace.punctuality(),
    })
}
