//! A client of a static world over UDP: feels what it knows at 1 kHz, whatever its servers do.
//!
//! The hand goes to and fro between two points (a sine in time), as a person who strokes along something; what it feels is
//! what the visitor renders. Datagrams are taken by the address they come from and believed by their seal only.

use std::{f64::consts::TAU, net::SocketAddr, time::Duration};

use cohold_core::num::Motion;
use cohold_live::endpoint::{Endpoint, Live, Punctuality, Stop, Ticker};
use cohold_live::key_file::entropy;
use cohold_live::refused::wrong;
use cohold_protocol::key::Key;
use cohold_sim::engine::{Actor, Out};
use serde::Serialize;

use crate::Error;
use crate::roles::static_scene::Download;
use crate::world::visitor::{Correspondent, Setup, Visitor};
use crate::world::{CONTROL_PERIOD_S, OBJECTS, TICKS_PER_PACKET, open_link};

/// Where to, how, and how long.
pub struct Options {
    /// Key, line, servers and range of the visitor.
    pub setup: Setup,
    /// Address on which this client listens.
    pub listen: SocketAddr,
    /// Servers and friend, and where they listen.
    pub parties: Vec<(Correspondent, SocketAddr)>,
    /// The hand goes from here …
    pub from_m: [f64; 2],
    /// … to here …
    pub to_m: [f64; 2],
    /// … and back in this time, s.
    pub stroke_s: f64,
    /// How long to visit if it is not stopped, s.
    pub duration_s: f64,
    /// The line of a client to tell straight, and the key of the two.
    pub friend: Option<(u32, Key)>,
}

impl Options {
    fn address(&self, party: Correspondent) -> Option<SocketAddr> {
        self.parties.iter().find(|(known, _)| *known == party).map(|(_, at)| *at)
    }

    /// Where the hand is in this control period.
    fn hand(&self, tick: u64) -> [Motion<f64>; 2] {
        let rate = TAU / self.stroke_s;
        let phase = rate * CONTROL_PERIOD_S * tick as f64;
        [0, 1].map(|axis| {
            let (from, half) = (self.from_m[axis], 0.5 * (self.to_m[axis] - self.from_m[axis]));
            Motion { position: from + half * (1.0 - libm::cos(phase)), velocity: half * rate * libm::sin(phase) }
        })
    }
}

/// Someone who was seen.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SightedClient {
    /// Number of the line that it is on.
    pub line: u32,
    /// Where it last said that it is, x and y, m.
    pub position_m: [f32; 2],
}

/// What a client saw and felt.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Report {
    /// Number of this client's own line.
    pub line: u32,
    /// Control periods that were run.
    pub ticks: u64,
    /// When everything in scope was held for the first time, s.
    pub complete_after_s: Option<f64>,
    /// Objects held from home.
    pub objects: usize,
    /// Objects that came, since the beginning, from the servers it has links to now.
    pub objects_taken: u32,
    /// Version of the world at home, for people; none if home was never heard.
    pub world_version: Option<u32>,
    /// Checksum of the world at home, 16 hexadecimal digits; none if home was never heard.
    pub world: Option<String>,
    /// Parts that were not what their checksum said.
    pub corrupt: u32,
    /// Number of the server that was home in the end.
    pub home: u8,
    /// How often it moved home from one server to another.
    pub moves: u32,
    /// Largest force on the hand, N.
    pub largest_force_n: f64,
    /// Largest change of the force in one control period, N.
    pub largest_step_n: f64,
    /// Control periods with a force.
    pub felt_ticks: u64,
    /// Control periods with a force while no server was heard.
    pub felt_alone_ticks: u64,
    /// Others that were seen in the last second.
    pub others: Vec<SightedClient>,
    /// Smoothed round trip to the home server, µs; none if none was measured.
    pub round_trip_us: Option<u32>,
    /// How well the control loop kept its ticks.
    pub punctuality: Punctuality,
}

struct Visit<'a> {
    visitor: Visitor,
    options: &'a Options,
    last: Option<[f64; 2]>,
    seen: Report,
}

impl Visit<'_> {
    fn downloads(&self) -> impl Iterator<Item = &Download<OBJECTS>> {
        self.options.setup.reachable.iter().filter_map(|number| self.visitor.download(*number))
    }

    fn hears_a_server(&self) -> bool {
        let mut links = self.options.setup.reachable.iter().filter_map(|number| self.visitor.link(*number));
        links.any(|link| link.session_number().is_some())
    }
}

impl Actor<SocketAddr> for Visit<'_> {
    type Packet = [u8];

    fn hear(&mut self, now_ns: u64, from: SocketAddr, datagram: &mut [u8], out: &mut Out<'_, SocketAddr, [u8]>) {
        let known = self.options.parties.iter().find(|(_, at)| *at == from);
        if let Some(&(party, _)) = known {
            self.visitor.receive(now_ns / 1_000, party, datagram, |_, bytes| out(from, bytes));
        }
    }

    fn act(&mut self, now_ns: u64, out: &mut Out<'_, SocketAddr, [u8]>) {
        let size = |force: [f64; 2]| libm::hypot(force[0], force[1]);
        let (options, force) = (self.options, self.visitor.step(self.options.hand(self.seen.ticks)));
        let alone = !self.hears_a_server();
        let (seen, last) = (&mut self.seen, self.last.replace(force).unwrap_or(force));
        seen.largest_force_n = seen.largest_force_n.max(size(force));
        seen.largest_step_n = seen.largest_step_n.max(size([force[0] - last[0], force[1] - last[1]]));
        seen.felt_ticks += u64::from(force != [0.0; 2]);
        seen.felt_alone_ticks += u64::from(force != [0.0; 2] && alone);
        if seen.ticks.is_multiple_of(u64::from(TICKS_PER_PACKET)) {
            // A datagram that the socket does not take now is asked for again.
            self.visitor.exchange(now_ns / 1_000, |to, bytes| _ = options.address(to).map(|to| out(to, bytes)));
        }
        if seen.complete_after_s.is_none() && self.visitor.is_complete() {
            seen.complete_after_s = Some(1e-9 * now_ns as f64);
        }
        seen.ticks += 1;
    }
}

impl Live for Visit<'_> {
    fn missing(&self) -> Option<String> {
        let home = self.visitor.link(self.visitor.home());
        let met = self.seen.complete_after_s.is_some()
            || home.is_some_and(|link| link.clock().round_trip_us().is_some())
            || self.downloads().any(|download| download.objects_taken() > 0 || download.world().is_some())
            || self.visitor.others().next().is_some();
        let servers = self.options.parties.iter().filter(|(party, _)| matches!(party, Correspondent::Server(_)));
        let addresses = || servers.map(|(_, address)| address.to_string()).collect::<Vec<_>>();
        (!met).then(|| match self.visitor.refused {
            Some((party, why)) => match self.options.address(party) {
                Some(address) => wrong(address, &why),
                None => wrong("a server", &why),
            },
            None => format!("nobody answered from {}, or nobody who holds the key", addresses().join(", ")),
        })
    }

    fn goodbye(&mut self, now_ns: u64, out: &mut Out<'_, SocketAddr, [u8]>) {
        let options = self.options;
        self.visitor.goodbye(now_ns / 1_000, |to, bytes| _ = options.address(to).map(|to| out(to, bytes)));
    }
}

/// Visits until the time is over, or it is stopped.
pub fn run(options: &Options, stop: &Stop) -> Result<Report, Error> {
    // Asked once before the clock starts; a generator that has worked once does not fail later.
    entropy()?;
    let line = options.setup.line;
    let mut visitor = Visitor::new(options.setup.clone(), || entropy().unwrap_or_default());
    if let Some((friend, key)) = &options.friend {
        let low = u8::from(line < *friend);
        visitor.befriend(*friend, open_link(key.clone(), [2 - low, 1 + low], entropy()?)?);
    }
    let mut visit = Visit { visitor, options, last: None, seen: Report { line, ..Report::default() } };
    let ticker = Ticker::realtime(Duration::from_secs_f64(CONTROL_PERIOD_S)).lasting(options.duration_s);
    let endpoint = Endpoint::polled(options.listen)?;
    options.parties.iter().try_for_each(|(_, address)| endpoint.reaches(*address))?;
    let punctuality = endpoint.run(ticker, f64::MAX, stop, &mut visit)?;
    let objects_taken = visit.downloads().map(Download::objects_taken).sum();
    let visitor = &visit.visitor;
    let download = visitor.download(visitor.home());
    let world = download.and_then(Download::world);
    Ok(Report {
        objects: download.map_or(0, |download| download.objects().count()),
        objects_taken,
        world_version: world.map(|(_, manifest)| manifest.version),
        world: world.map(|(sum, _)| format!("{sum:016x}")),
        corrupt: visitor.corrupt,
        home: visitor.home(),
        moves: visitor.moves(),
        others: visitor.others().map(|other| SightedClient { line: other.who, position_m: other.position }).collect(),
        round_trip_us: visitor.link(visitor.home()).and_then(|link| link.clock().round_trip_us()),
        punctuality,
        ..visit.seen
    })
}
