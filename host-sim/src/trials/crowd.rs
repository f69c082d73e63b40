//! Very many clients at one server, to see how many it holds and where it bends.
//!
//! Server and clients are two threads with a socket each, on loopback; all clients share theirs, which works because a server
//! knows a client by its line and session and not by its address. Every client has its own link and keys, downloads its
//! neighbourhood of the world, walks about in it, and says where it is 125 times a second; the clients' packets are spread
//! evenly over the packet period. Each is answered at once with the places of others.
//!
//! **What is told**: the server's turnaround, from when a client handed its packet to the system ([`crate::live::serve`]), the
//! round trip from a client's packet to the answer that names it, and how many were answered. A load that is late by more than
//! a quarter of a packet period does not catch up in a burst that no independent clients would make; it goes on from there, and
//! the packets per second that it managed are told.

use std::collections::HashMap;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use haptic_protocol::wire::{Message, Presence, Sighting};
use haptic_protocol::{key::Key, link::Link, roles::static_scene::Download};
use haptic_sim::{key_file::entropy, node::Says as _};
use serde::Serialize;

use crate::live::endpoint::{Endpoint, Stop, realtime};
use crate::live::quantiles::{Quantiles, Times};
use crate::live::serve::{self, Computed};
use crate::shared::world::host::Host;
use crate::shared::world::{CLIENT, PACKET_US, World, line_of, look_around, open_link};

/// The server's number.
const SERVER: u8 = 1;
/// Packets of a client that may be under way before their round trip is not measured any more.
const UNDER_WAY: usize = 64;
/// Objects that a client of the crowd has room for.
const NEAR: usize = 32;
/// How far around itself a client of the crowd looks, m.
const RADIUS_M: f32 = 0.1;

/// How long the load rests every millisecond.
const REST: Duration = Duration::from_micros(80);
/// Long enough to take a few datagrams.
const FEW: Duration = Duration::from_micros(50);
/// A load that is later than this does not catch up, ns.
const LATE_NS: u64 = 250 * PACKET_US;

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
pub(crate) struct Report {
    pub(crate) clients: u32,
    /// Clients that had their neighbourhood before the measurement ended.
    pub(crate) complete: u32,
    pub(crate) measured_s: f64,
    pub(crate) packets: u64,
    /// Packets a second of each client; 125 if the load was never late.
    pub(crate) rate_hz: f64,
    pub(crate) answered: u64,
    /// Objects' places that the answers carried.
    pub(crate) sightings: u64,
    /// From a client's packet to its answer, at the client.
    pub(crate) round_trip: Quantiles,
    /// How late the load was with its packets.
    pub(crate) load_late: Quantiles,
    pub(crate) load_cpu_share: Option<f64>,
    pub(crate) load_realtime_priority: bool,
    pub(crate) server: serve::Report,
}

impl Report {
    /// Share of the packets that were answered.
    pub(crate) fn answered_share(&self) -> f64 {
        self.answered as f64 / self.packets.max(1) as f64
    }
}

/// `clients` clients at one server of `world`, for `warm_up_s` and then, measured, for `seconds`, or until it is stopped.
pub(crate) fn run(world: &World, clients: u32, warm_up_s: f64, seconds: f64, stop: &Stop) -> Result<Report, String> {
    let (key, start) = (Key::new(entropy()?), Instant::now());
    let loopback = SocketAddr::from(([127, 0, 0, 1], 0));
    let (server, load) = (Endpoint::answering(loopback)?.since(start), Endpoint::polled(loopback)?.since(start));
    let mut host = Host::new(key.clone(), SERVER, clients, world.clone(), None, || entropy().unwrap_or_default())?;
    let sent = (0..clients).map(|_| AtomicU64::new(0)).collect::<Vec<_>>();
    let sent_ns = |line: u32| sent.get(line as usize - 1).map(|sent| sent.load(Ordering::Relaxed));
    let done = Stop::default();
    std::thread::scope(|scope| {
        let options = serve::Options { duration_s: f64::MAX, warm_up_s, sent_ns };
        let serving = scope.spawn(|| serve::run(&server, &mut host, options, &done));
        let load = Load::new(&load, server.address, &key, &sent).and_then(|load| load.run(warm_up_s, seconds, stop));
        done.ask();
        let server = serving.join().map_err(|_| "the server's thread ended".to_owned())??;
        Ok(load?.report(server))
    })
}

/// The crowd and what is measured of it.
struct Load<'a> {
    endpoint: &'a Endpoint,
    server: SocketAddr,
    /// When each client last sent, ns.
    sent: &'a [AtomicU64],
    clients: Vec<Client>,
    sessions: HashMap<u32, u32>,
    measured: Option<Computed>,
    round_trip: Times,
    late: Times,
    rested_ns: u64,
    seen: Report,
}

impl<'a> Load<'a> {
    fn new(endpoint: &'a Endpoint, server: SocketAddr, key: &Key, sent: &'a [AtomicU64]) -> Result<Self, String> {
        let count = sent.len();
        let clients: Result<_, String> = (1..=count as u32)
            .map(|line| {
                let link = open_link(key.line(line), [CLIENT, SERVER], entropy()?)?.on_line(line);
                // Spread over the room, so that neighbourhoods differ.
                let part = line as f32 / count as f32;
                let centre = [0.8 * part - 0.4, 0.2 * (17.0 * part).fract() - 0.1];
                Ok(Client { link, download: Box::default(), tick: 0, sent_ns: [0; UNDER_WAY], centre, complete: false })
            })
            .collect();
        Ok(Self {
            endpoint,
            server,
            sent,
            clients: clients?,
            sessions: HashMap::new(),
            measured: None,
            round_trip: Times::new(),
            late: Times::new(),
            rested_ns: 0,
            seen: Report { clients: count as u32, ..Report::default() },
        })
    }

    fn run(mut self, warm_up_s: f64, seconds: f64, stop: &Stop) -> Result<Self, String> {
        self.seen.load_realtime_priority = realtime();
        let (period_ns, count) = (1_000 * PACKET_US, self.clients.len() as u64);
        let (warm_ns, end_ns) = ((1e9 * warm_up_s) as u64, (1e9 * (warm_up_s + seconds)) as u64);
        let (mut next, mut slipped_ns, mut measured_ns) = (0_u64, self.endpoint.now_ns(), 0);
        loop {
            // Packet number `next` of the crowd: the clients in turn, evenly over each packet period.
            let due_ns = slipped_ns + next / count * period_ns + next % count * period_ns / count;
            self.wait(due_ns)?;
            let now_ns = self.endpoint.now_ns();
            if now_ns >= end_ns || stop.is_asked() {
                break;
            }
            if self.measured.is_none() && now_ns >= warm_ns {
                self.measured = Some(Computed::now());
                measured_ns = now_ns;
            }
            let late_ns = now_ns.saturating_sub(due_ns);
            slipped_ns += if late_ns > LATE_NS { late_ns } else { 0 };
            if self.measured.is_some() {
                self.late.add(late_ns);
            }
            self.exchange((next % count) as usize);
            next += 1;
        }
        if let Some(measured) = &self.measured {
            self.seen.measured_s = 1e-9 * (self.endpoint.now_ns() - measured_ns) as f64;
            self.seen.load_cpu_share = measured.share();
        }
        // What is under way still counts.
        self.wait(self.endpoint.now_ns() + 100_000_000)?;
        Ok(self)
    }

    /// Takes what comes until `due_ns`; if that is over, what comes in the time of a few, so that answers do not hold up the load.
    fn wait(&mut self, due_ns: u64) -> Result<(), String> {
        loop {
            let mut came = 0;
            let left_ns = due_ns.saturating_sub(self.endpoint.now_ns());
            let until = Instant::now() + Duration::from_nanos(left_ns).max(FEW);
            let endpoint = self.endpoint;
            endpoint.drain(until, |_, datagram| {
                came += 1;
                self.receive(datagram);
            })?;
            let now_ns = endpoint.now_ns();
            let left_ns = due_ns.saturating_sub(now_ns);
            if left_ns == 0 {
                return Ok(());
            }
            if came == 0 && left_ns > 200_000 {
                std::thread::sleep(Duration::from_nanos(left_ns - 100_000));
            }
            // A thread of real-time priority that never rests is stopped by the system, and for longer.
            if now_ns > self.rested_ns + 1_000_000 {
                std::thread::sleep(REST);
                self.rested_ns = endpoint.now_ns();
            }
        }
    }

    /// One client's packet period.
    fn exchange(&mut self, at: usize) {
        let now_ns = self.endpoint.now_ns();
        let now = now_ns / 1_000;
        let Some(client) = self.clients.get_mut(at) else { return };
        let (endpoint, server) = (self.endpoint, self.server);
        let send = |bytes: &[u8]| _ = endpoint.send(server, bytes);
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
            if client.link.say(now, said, send) {
                client.sent_ns[client.tick as usize % UNDER_WAY] = now_ns;
                self.seen.packets += u64::from(self.measured.is_some());
            }
            if let Some(ask) = client.download.poll(now, 4 * PACKET_US) {
                client.link.say(now, ask, send);
            }
        } else {
            // It would have said something.
            self.seen.packets += u64::from(self.measured.is_some());
        }
        client.link.say_due(now, send);
    }

    fn receive(&mut self, datagram: &mut [u8]) {
        let now_ns = self.endpoint.now_ns();
        let line = line_of(datagram, |session| self.sessions.get(&session).copied());
        let at = line.map_or(0, |line| line as usize).wrapping_sub(1);
        let Some(client) = self.clients.get_mut(at) else { return };
        match client.link.receive(now_ns / 1_000, datagram) {
            Ok(Some(Message::Presence(told))) => {
                let sent_ns = std::mem::take(&mut client.sent_ns[told.tick as usize % UNDER_WAY]);
                if self.measured.is_some() && sent_ns > 0 {
                    self.seen.answered += 1;
                    self.seen.sightings += told.seen().len() as u64;
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
            self.endpoint.send(self.server, bytes);
        });
    }

    fn report(self, server: serve::Report) -> Report {
        let Report { clients, packets, measured_s, .. } = self.seen;
        Report {
            complete: self.clients.iter().filter(|client| client.complete).count() as u32,
            rate_hz: packets as f64 / (measured_s * f64::from(clients)).max(1e-9),
            round_trip: self.round_trip.quantiles(),
            load_late: self.late.quantiles(),
            server,
            ..self.seen
        }
    }
}
