//! Very many clients at one server, to see how many it holds and where it bends.
//!
//! Server and clients are two threads with a socket each, on loopback; all clients share theirs, which works because a server
//! knows a client by its line and session and not by its address. Every client has its own link and keys, downloads its
//! neighbourhood of the world, walks about in it, and says where it is 125 times a second; the clients' packets are spread
//! evenly over the packet period ([`super::load`]). They arrive evenly over half of the warm-up: links that began together would
//! probe together for good, as no independent clients do. Each is answered at once with the places of others.
//!
//! **What is measured**: the server's turnaround, from when a client handed its packet to the system ([`crate::live::serve`]), the
//! round trip from a client's packet to the answer that names it, how many were answered, and how many packets a second the load
//! managed.

use std::collections::HashMap;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use cohold_live::endpoint::{Endpoint, Stop};
use cohold_live::key_file::entropy;
use cohold_live::quantiles::{Quantiles, Times};
use cohold_protocol::wire::{Message, Presence, Sighting};
use cohold_protocol::{key::Key, link::Link};
use serde::Serialize;

use super::beside::{self, Echo};
use super::load::{self, Clients, Span};
use crate::Error;
use crate::live::serve;
use crate::roles::static_scene::Download;
use crate::world::host::Host;
use crate::world::{CLIENT, PACKET_US, World, line_of, look_around, open_link};

/// Number of the server.
const SERVER: u8 = 1;
/// Packets of a client that may be under way before their round trip is not measured any more.
const UNDER_WAY: usize = 64;
/// Objects that a client of the crowd has room for.
const NEAR: usize = 32;
/// How far around itself a client of the crowd looks, m.
const RADIUS_M: f32 = 0.1;

/// One client of the crowd.
struct Client {
    link: Link,
    download: Box<Download<NEAR>>,
    tick: u32,
    sent_ns: [u64; UNDER_WAY],
    centre: [f32; 2],
    complete: bool,
}

/// What became of a crowd.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Report {
    /// Number of clients in the crowd.
    pub clients: u32,
    /// Clients that had their neighbourhood before the measurement ended.
    pub complete: u32,
    /// Length of the measurement, s.
    pub measured_s: f64,
    /// Packets that the clients sent while it was measured.
    pub packets: u64,
    /// Packets a second of each client; 125 if the load was never late.
    pub rate_hz: f64,
    /// Packets of these that the server answered.
    pub answered: u64,
    /// Objects' places that the answers carried.
    pub sightings: u64,
    /// From a client's packet to its answer, at the client.
    pub round_trip: Quantiles,
    /// How late the load was with its packets.
    pub load_late: Quantiles,
    /// Share of one processor that the load's thread took.
    pub load_cpu_share: Option<f64>,
    /// Whether the load's thread had real-time priority.
    pub load_realtime_priority: bool,
    /// Mean length of what the server says, bytes.
    pub answer_bytes: f64,
    /// What the server says of itself.
    pub server: serve::Report,
    /// A bare echo of as many datagrams, if that was asked for.
    pub echo: Option<Echo>,
    /// The server's processor time for a pair of datagrams over the echo's.
    pub work_over_echo: Option<f64>,
}

impl Report {
    /// Share of the packets that were answered.
    pub fn answered_share(&self) -> f64 {
        self.answered as f64 / self.packets.max(1) as f64
    }

    /// A bare echo of as many datagrams a second as the server took, for as long.
    pub fn beside_echo(self, span: Span, stop: &Stop) -> Result<Self, Error> {
        let rate_hz = self.server.answer.samples as f64 / self.measured_s.max(1e-9);
        let callers = ((rate_hz * 1e-6 * PACKET_US as f64) as u64).max(1);
        let echo = beside::echo(callers, self.answer_bytes.round() as usize, span, stop)?;
        let work_over_echo = self.server.us_per_pair.zip(echo.us_per_pair).map(|(work, echo)| work / echo);
        Ok(Self { echo: Some(echo), work_over_echo, ..self })
    }
}

/// `clients` clients at one server of `world`, for the time of `span`, or until it is stopped.
pub fn run(world: &World, clients: u32, span: Span, stop: &Stop) -> Result<Report, Error> {
    let (key, start) = (Key::new(entropy()?), Instant::now());
    let loopback = SocketAddr::from(([127, 0, 0, 1], 0));
    let (server, load) = (Endpoint::answering(loopback)?.since(start), Endpoint::polled(loopback)?.since(start));
    let mut host = Host::new(key.clone(), SERVER, clients, world.clone(), None, || entropy().unwrap_or_default())?;
    let sent = (0..clients).map(|_| AtomicU64::new(0)).collect::<Vec<_>>();
    let sent_ns = |line: u32| sent.get(line as usize - 1).map(|sent| sent.load(Ordering::Relaxed));
    let done = Stop::default();
    std::thread::scope(|scope| {
        let options = serve::Options { duration_s: f64::MAX, warm_up_s: span.warm_up_s, sent_ns };
        let serving = scope.spawn(|| serve::run(&server, &mut host, options, &done));
        let made = Load::new(&key, &sent, span.warm_up_s).and_then(|mut crowd| {
            let kept = load::run(&load, server.address, clients.into(), span, stop, &mut crowd)?;
            Ok((crowd, kept))
        });
        done.ask();
        let server = serving.join().map_err(|_| "the server's thread ended".to_owned())??;
        let (crowd, kept) = made?;
        Ok(crowd.report(kept, server))
    })
}

/// The crowd and what is measured of it.
struct Load<'a> {
    /// When each client last sent, ns.
    sent: &'a [AtomicU64],
    /// From the arrival of one client to that of the next, ns.
    arrival_ns: u64,
    clients: Vec<Client>,
    sessions: HashMap<u32, u32>,
    round_trip: Times,
    /// Datagrams that came, and their bytes.
    came: [u64; 2],
    seen: Report,
}

impl<'a> Load<'a> {
    fn new(key: &Key, sent: &'a [AtomicU64], warm_up_s: f64) -> Result<Self, Error> {
        let count = sent.len();
        let clients: Result<_, Error> = (1..=count as u32)
            .map(|line| {
                let link = open_link(key.line(line), [CLIENT, SERVER], entropy()?)?.on_line(line);
                // Spread over the room, so that neighbourhoods differ.
                let part = line as f32 / count as f32;
                let centre = [0.8 * part - 0.4, 0.2 * (17.0 * part).fract() - 0.1];
                Ok(Client { link, download: Box::default(), tick: 0, sent_ns: [0; UNDER_WAY], centre, complete: false })
            })
            .collect();
        Ok(Self {
            sent,
            arrival_ns: (0.5e9 * warm_up_s) as u64 / count.max(1) as u64,
            clients: clients?,
            sessions: HashMap::new(),
            round_trip: Times::default(),
            came: [0; 2],
            seen: Report { clients: count as u32, ..Report::default() },
        })
    }

    fn report(self, kept: load::Kept, server: serve::Report) -> Report {
        let (Report { clients, packets, .. }, measured_s) = (self.seen.clone(), kept.measured_s);
        Report {
            complete: self.clients.iter().filter(|client| client.complete).count() as u32,
            rate_hz: packets as f64 / (measured_s * f64::from(clients)).max(1e-9),
            round_trip: self.round_trip.quantiles(),
            measured_s,
            answer_bytes: self.came[1] as f64 / self.came[0].max(1) as f64,
            load_late: kept.late,
            load_cpu_share: kept.cpu_share,
            load_realtime_priority: kept.realtime_priority,
            server,
            ..self.seen
        }
    }
}

impl Clients for Load<'_> {
    fn exchange(&mut self, at: usize, now_ns: u64, measured: bool, say: &mut dyn FnMut(&[u8])) {
        if now_ns < at as u64 * self.arrival_ns {
            return;
        }
        let now = now_ns / 1_000;
        let Some(client) = self.clients.get_mut(at) else { return };
        self.sent[at].store(now_ns, Ordering::Relaxed);
        client.tick = client.tick.wrapping_add(1);
        // Once around a circle of 5 cm in 10 s.
        let angle = std::f32::consts::TAU * client.tick as f32 / 1_250.0;
        let position = [client.centre[0] + 0.05 * angle.cos(), client.centre[1] + 0.05 * angle.sin()];
        look_around(&mut client.download, position, RADIUS_M);
        if client.link.session_number().is_some() {
            let speed = 0.05 * std::f32::consts::TAU / 10.0;
            let velocity = [-speed * angle.sin(), speed * angle.cos()];
            let said = Presence::new(client.tick, [Sighting { who: 0, position, velocity }]);
            if client.link.say(now, said, &mut *say) {
                // An answer to what was said before does not count.
                client.sent_ns[client.tick as usize % UNDER_WAY] = if measured { now_ns } else { 0 };
                self.seen.packets += u64::from(measured);
            }
            if let Some(ask) = client.download.poll(now, 4 * PACKET_US) {
                client.link.say(now, ask, &mut *say);
            }
        } else {
            // It would have said something.
            self.seen.packets += u64::from(measured);
        }
        client.link.say_due(now, say);
    }

    fn receive(&mut self, now_ns: u64, measured: bool, datagram: &mut [u8], say: &mut dyn FnMut(&[u8])) {
        if measured {
            self.came[0] += 1;
            self.came[1] += datagram.len() as u64;
        }
        let line = line_of(datagram, |session| self.sessions.get(&session).copied());
        let at = line.map_or(0, |line| line as usize).wrapping_sub(1);
        let Some(client) = self.clients.get_mut(at) else { return };
        match client.link.receive(now_ns / 1_000, datagram) {
            Ok(Some(Message::Presence(presence))) => {
                let sent_ns = std::mem::take(&mut client.sent_ns[presence.tick as usize % UNDER_WAY]);
                if measured && sent_ns > 0 {
                    self.seen.answered += 1;
                    self.seen.sightings += presence.seen().len() as u64;
                    self.round_trip.add(now_ns - sent_ns);
                }
            }
            Ok(Some(Message::Part(part))) => {
                client.download.take(&part);
                client.complete |= client.download.is_complete();
            }
            _ => {}
        }
        if let Some(session) = client.link.session_number() {
            self.sessions.insert(session, at as u32 + 1);
        }
        client.link.say_due(now_ns / 1_000, |bytes| {
            self.sent[at].store(now_ns, Ordering::Relaxed);
            say(bytes);
        });
    }
}
