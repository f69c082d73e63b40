//! A [`Hub`] in real time: one thread, one UDP socket, a beat from the operating system.
//!
//! As a peer's ([`super::peer`]): at every control period the socket is emptied for half a period at the most, then the hub
//! beats. So what was heard in a packet period goes through the junction at its end, the newest of each line.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use haptic_protocol::key::Key;
use haptic_protocol::link::Notice;
use serde::Serialize;

use super::hub::{Hub, Line, number_on};
use super::pace::{Pace, Punctuality};
use super::peer::Other;
use super::socket::{drain, open};
use crate::shared::cooperative::junction::{Energy, Port};
use haptic_sim::key_file::entropy;
use haptic_sim::scene::Scene;

/// Where, for how many and how long.
#[derive(Clone, Debug)]
pub struct Options {
    /// Peers.
    pub users: usize,
    /// Where the hub listens.
    pub listen: SocketAddr,
    /// Time from when all are there, s.
    pub duration_s: f64,
    /// How long to wait for all of them, s.
    pub patience_s: f64,
}

/// What the hub saw of one line.
#[derive(Clone, Debug, Serialize)]
pub struct LineReport {
    /// 1, 2, …
    pub line: u32,
    /// Which number of the scene its peer has.
    pub number: u8,
    /// Where the peer last proved itself from.
    pub address: Option<String>,
    /// How many lives of the peer there were.
    pub lives: usize,
    /// Wave energy at the hub's end.
    #[serde(flatten)]
    pub energy: Energy,
    /// Where the peer last said that its copy is, mm.
    pub copy_mm: Option<f64>,
    /// What the peer last said about itself.
    pub said: Option<Other>,
    /// Round trip, µs.
    pub round_trip_us: Option<u32>,
    /// Datagrams taken.
    pub datagrams_taken: u32,
    /// Datagrams of the peer that never came.
    pub datagrams_missing: u32,
    /// What the link reported, in order, with the time in s since the start.
    pub notices: Vec<(f64, String)>,
}

impl LineReport {
    fn new((line, (end, port)): (u32, (&Line<SocketAddr>, &Port))) -> Self {
        let counts = end.link().counts();
        let told = |(at_us, notice): &(u64, Notice)| (*at_us as f64 * 1e-6, format!("{notice:?}"));
        Self {
            line,
            number: number_on(line),
            address: end.address().map(|address| address.to_string()),
            lives: end.notices().iter().filter(|(_, notice)| matches!(notice, Notice::NewPeer { .. })).count(),
            energy: port.energy,
            copy_mm: end.heard().map(|said| 1e3 * f64::from(said.object_position)),
            said: end.heard().map(Other::new),
            round_trip_us: end.link().clock().round_trip_us(),
            datagrams_taken: counts.taken,
            datagrams_missing: counts.missing,
            notices: end.notices().iter().map(told).collect(),
        }
    }
}

/// What the hub saw.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Packet periods since all were there.
    pub packets: u64,
    /// Wave energy sent over wave energy that the peers put in; never above 1.
    pub energy_out_over_in: f64,
    /// Where the lines meet, mm from where they met first.
    pub object_mm: f64,
    /// Largest distance between two copies as the peers last told, mm; they tell every half second, not at one instant.
    pub apart_mm: f64,
    /// Datagrams that no line took: forged, replayed, broken, or of a peer without its line's key.
    pub datagrams_refused: u64,
    /// The lines.
    pub lines: Vec<LineReport>,
    /// How well the beat was kept.
    pub punctuality: Punctuality,
}

/// Runs the hub to the end.
///
/// # Errors
/// A scene that is refused, a socket that cannot be opened, or peers that are not all there in time: in one line.
pub fn run(scene: &Scene, key: &Key, options: &Options) -> Result<Report, String> {
    let mut hub = Hub::new(scene, options.users, key, entropy)?;
    let socket = open(options.listen)?;
    let timing = &scene.peer.timing;
    let period = Duration::from_secs_f64(timing.control_period_s);
    let packet_s = timing.control_period_s * f64::from(timing.ticks_per_packet);
    let packets = (options.duration_s / packet_s).round() as u64;
    let mut pace = Pace::new(period);
    // A datagram that the socket does not take now is late, and late flow is worth nothing.
    let send = |to: SocketAddr, bytes: &[u8]| {
        let _ = socket.send_to(bytes, to);
    };
    while hub.packets().is_none_or(|so_far| so_far < packets) {
        pace.wait();
        let now_us = pace.now_us();
        drain(&socket, Instant::now() + period / 2, |from, datagram| hub.receive(now_us, from, datagram, send));
        let waited = hub.packets().is_none();
        hub.beat(now_us, send);
        if waited && hub.packets().is_some() {
            eprintln!("all {} are there: arm the boards", options.users);
        }
        if hub.packets().is_none() {
            waiting(&hub, now_us as f64 * 1e-6, options)?;
        }
    }
    let energy = hub.junction().energy();
    let lines: Vec<LineReport> = (1..).zip(hub.lines()).map(LineReport::new).collect();
    let copies = || lines.iter().filter_map(|line| line.copy_mm);
    Ok(Report {
        packets,
        energy_out_over_in: if energy.put_in_j > 0.0 { energy.sent_j / energy.put_in_j } else { 1.0 },
        object_mm: 1e3 * hub.junction().motion.position,
        apart_mm: copies().reduce(f64::max).unwrap_or(0.0) - copies().reduce(f64::min).unwrap_or(0.0),
        datagrams_refused: hub.refused(),
        lines,
        punctuality: pace.punctuality(),
    })
}

/// What is wrong while not all are there.
fn waiting(hub: &Hub<SocketAddr>, waited_s: f64, options: &Options) -> Result<(), String> {
    for (line, (end, _)) in (1..).zip(hub.lines()) {
        if let Some(table) = end.link().refused() {
            return Err(format!(
                "the peer on line {line} was told other parameters: table [{table}] of the scene differs"
            ));
        }
    }
    if waited_s <= options.patience_s {
        return Ok(());
    }
    let absent = (1..).zip(hub.lines()).filter(|(_, (end, _))| !end.is_joined());
    let absent: Vec<String> =
        absent.map(|(line, _): (u32, _)| format!("{line} (peer number {})", number_on(line))).collect();
    Err(format!(
        "only {} of {} peers came within {} s; nobody on line {} at {}, or nobody who holds its key",
        options.users - absent.len(),
        options.users,
        options.patience_s,
        absent.join(", "),
        options.listen
    ))
}
