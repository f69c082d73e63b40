//! A client of a static world over UDP: feels what it knows at 1 kHz, whatever its servers do.
//!
//! The hand goes to and fro between two points (a sine in time), as a person who strokes along something; what it feels is
//! what the visitor renders. Datagrams are taken by the address they come from and believed by their seal only.

use haptic_sim::key_file::entropy;
use std::net::{SocketAddr, UdpSocket};
use std::time::Duration;

use haptic_core::num::Motion;
use haptic_protocol::ends::Ends;
use haptic_protocol::key::Key;
use haptic_protocol::link::{Config, Link};
use haptic_protocol::roles::static_scene::Download;
use haptic_protocol::wire::PeerId;
use serde::Serialize;

use super::pace::{Pace, Punctuality};
use crate::shared::visit::visitor::{Party, Setup, Visitor};
use crate::shared::visit::{PACKET_US, TICKS_PER_PACKET, parameters};
use crate::shared::world::{CONTROL_PERIOD_S, OBJECTS};

/// Another client that is told straight where this one is.
#[derive(Clone, Debug)]
pub struct Friend {
    /// Its line.
    pub line: u32,
    /// Where it listens.
    pub address: SocketAddr,
    /// The key of the two.
    pub key: Key,
}

/// Where to, how, and how long.
#[derive(Clone, Debug)]
pub struct Options {
    /// The key of this client's line.
    pub key: Key,
    /// Its line.
    pub line: u32,
    /// Where this client listens; port 0 is any.
    pub listen: SocketAddr,
    /// Servers by number.
    pub servers: Vec<(u8, SocketAddr)>,
    /// The server to begin at.
    pub home: u8,
    /// How far around itself it wants to know, m; `None`: everything.
    pub radius_m: Option<f32>,
    /// The hand goes from here …
    pub from_m: [f64; 2],
    /// … to here …
    pub to_m: [f64; 2],
    /// … and back in this time, s.
    pub stroke_s: f64,
    /// How long, s.
    pub duration_s: f64,
    /// A client to tell straight.
    pub friend: Option<Friend>,
}

/// Someone who was seen.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Seen {
    /// Line.
    pub line: u32,
    /// Where, m.
    pub position_m: [f32; 2],
}

/// What a client saw and felt.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Its line.
    pub line: u32,
    /// Control periods.
    pub ticks: u64,
    /// When everything in scope was held for the first time, s.
    pub complete_after_s: Option<f64>,
    /// Objects held from home.
    pub objects: usize,
    /// Objects that came, since the beginning, from the servers it has links to now.
    pub objects_taken: u32,
    /// Version of the world.
    pub world_version: Option<u32>,
    /// Checksum of the world.
    pub world: Option<String>,
    /// Parts that were not what their checksum said.
    pub corrupt: u32,
    /// Where it is at home.
    pub home: u8,
    /// How often it moved.
    pub moves: u32,
    /// Largest force, N.
    pub largest_force_n: f64,
    /// Largest change of the force in one control period, N.
    pub largest_step_n: f64,
    /// Control periods with a force.
    pub felt_ticks: u64,
    /// Control periods with a force while no server was heard.
    pub felt_alone_ticks: u64,
    /// Others that were seen in the last second.
    pub others: Vec<Seen>,
    /// Round trip to home, µs.
    pub round_trip_us: Option<u32>,
    /// How well the 1 kHz beat was kept.
    pub punctuality: Punctuality,
}

/// Visits until the time is over.
///
/// # Errors
/// A socket that cannot be opened, or no randomness: in one line.
pub fn run(options: &Options) -> Result<Report, String> {
    let socket =
        UdpSocket::bind(options.listen).map_err(|cause| format!("cannot listen on {}: {cause}", options.listen))?;
    socket.set_nonblocking(true).map_err(|cause| format!("cannot poll the socket: {cause}"))?;
    // Asked once before the clock starts; a generator that has worked once does not fail later.
    entropy()?;
    let reachable = options.servers.iter().map(|(number, _)| *number).collect();
    let Options { line, home, radius_m, .. } = *options;
    let setup = Setup { key: options.key.clone(), line, home, reachable, radius_m };
    let mut visitor = Visitor::new(setup, || entropy().unwrap_or_default());
    if let Some(friend) = &options.friend {
        let low = line < friend.line;
        let link = Link::new(Config {
            key: friend.key.clone(),
            ends: Ends { local: PeerId(2 - u8::from(low)), remote: PeerId(1 + u8::from(low)) },
            packet_period_us: PACKET_US as u32,
            parameters: parameters(),
            entropy: entropy()?,
        });
        visitor.befriend(friend.line, link.map_err(|error| error.to_string())?);
    }
    let address = |party: Party| match party {
        Party::Server(number) => options.servers.iter().find(|(known, _)| *known == number).map(|(_, at)| *at),
        Party::Client(line) => {
            options.friend.as_ref().filter(|friend| friend.line == line).map(|friend| friend.address)
        }
    };
    let party = |from: SocketAddr| {
        let server = options.servers.iter().find(|(_, at)| *at == from).map(|(number, _)| Party::Server(*number));
        let friend = options.friend.as_ref().filter(|friend| friend.address == from);
        server.or_else(|| friend.map(|friend| Party::Client(friend.line)))
    };
    // A datagram that the socket does not take now is asked for again.
    let send = |to: Party, bytes: &[u8]| drop(address(to).map(|to| socket.send_to(bytes, to)));
    let ticks = (options.duration_s / CONTROL_PERIOD_S).round() as u64;
    let mut pace = Pace::new(Duration::from_secs_f64(CONTROL_PERIOD_S));
    let mut came = [0; 2048];
    let (mut complete_after_s, mut last) = (None, None::<[f64; 2]>);
    let (mut largest_force_n, mut largest_step_n) = (0.0_f64, 0.0_f64);
    let (mut felt_ticks, mut felt_alone_ticks) = (0, 0);
    for tick in 0..ticks {
        pace.wait();
        let now = pace.now_us();
        while let Ok((len, from)) = socket.recv_from(&mut came) {
            if let Some(from) = party(from) {
                visitor.receive(now, from, &mut came[..len], send);
            }
        }
        let phase = std::f64::consts::TAU * CONTROL_PERIOD_S * tick as f64 / options.stroke_s;
        let hand = [0, 1].map(|axis| {
            let (from, to) = (options.from_m[axis], options.to_m[axis]);
            let half = 0.5 * (to - from);
            let rate = std::f64::consts::TAU / options.stroke_s;
            Motion { position: from + half * (1.0 - libm::cos(phase)), velocity: half * rate * libm::sin(phase) }
        });
        let force = visitor.step(hand);
        let size = |force: [f64; 2]| libm::hypot(force[0], force[1]);
        largest_force_n = largest_force_n.max(size(force));
        largest_step_n = largest_step_n.max(last.map_or(0.0, |last| size([force[0] - last[0], force[1] - last[1]])));
        last = Some(force);
        if force != [0.0; 2] {
            felt_ticks += 1;
            let heard = options
                .servers
                .iter()
                .any(|(number, _)| visitor.link(*number).is_some_and(|link| link.session_number().is_some()));
            felt_alone_ticks += u64::from(!heard);
        }
        if tick % u64::from(TICKS_PER_PACKET) == 0 {
            visitor.exchange(now, send);
        }
        if complete_after_s.is_none() && visitor.is_complete() {
            complete_after_s = Some(1e-6 * now as f64);
        }
    }
    let download = visitor.download(visitor.home());
    let world = download.and_then(Download::<OBJECTS>::world);
    Ok(Report {
        line: options.line,
        ticks,
        complete_after_s,
        objects: download.map_or(0, |download| download.objects().count()),
        objects_taken: options
            .servers
            .iter()
            .filter_map(|(number, _)| visitor.download(*number))
            .map(Download::<OBJECTS>::objects_taken)
            .sum(),
        world_version: world.map(|(_, manifest)| manifest.version),
        world: world.map(|(sum, _)| format!("{sum:016x}")),
        corrupt: visitor.corrupt(),
        home: visitor.home(),
        moves: visitor.moves(),
        largest_force_n,
        largest_step_n,
        felt_ticks,
        felt_alone_ticks,
        others: visitor.others().map(|other| Seen { line: other.who, position_m: other.position }).collect(),
        round_trip_us: visitor.link(visitor.home()).and_then(|link| link.clock().round_trip_us()),
        punctuality: pace.punctuality(),
    })
}
