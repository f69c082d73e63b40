//! A hub ([`Hub`]) in real time, on an endpoint. What was heard in a packet period goes through the junction at its end, the newest
//! of each line.

use cohold_core::num::Motion;
use cohold_live::endpoint::{Endpoint, Live, Punctuality, Span, Stop, Ticker};
use cohold_live::key_file::entropy;
use cohold_live::watch::{LiveOptions, LiveSummary};
use cohold_live::{peer::RemoteReport, tell::Noticed};
use cohold_protocol::key::Key;
use cohold_sim::engine::{Actor, Out};
use cohold_sim::run::AXIS_NAMES;
use cohold_sim::{of_axes, scene::Scene};
use serde::Serialize;

use super::hub_watch::HubWatch;
use crate::Error;
use crate::cooperative::hub::{End, Hub, line_wrong, number_on};
use crate::cooperative::junction::{Energy, Port};

pub use std::{net::SocketAddr, time::Duration};

/// What the hub saw of one line.
#[derive(Serialize)]
pub struct LineReport {
    /// Number of the line, counted from 1.
    pub line: u32,
    /// Number of the scene's peer that belongs on it: 1 on odd lines, 2 on even ones.
    pub number: u8,
    /// Where its peer is answered; none where no session has begun.
    pub address: Option<String>,
    /// How many lives of the peer there were.
    pub lives: u64,
    /// Who was refused on this line last, and why.
    pub refused: Option<String>,
    /// Wave energy at the hub's end of the line, J, summed over all shared axes.
    #[serde(flatten)]
    pub energy: Energy,
    /// Where the peer last said that its copy is, mm; of several shared axes along the first.
    pub copy_mm: Option<f64>,
    /// What the peer's newest telemetry says; none before any came.
    pub said: Option<RemoteReport>,
    /// Smoothed round trip of the line, µs; none if none was measured.
    pub round_trip_us: Option<u32>,
    /// Sealed datagrams of the peer that were opened and accepted.
    pub datagrams_taken: u32,
    /// Sealed datagrams of the peer that never came.
    pub datagrams_missing: u32,
    /// What the link reported last, in order.
    pub notices: Vec<Noticed>,
}

impl LineReport {
    fn new<const SHARED: usize>((line, (end, port)): (u32, (&End<SocketAddr, SHARED>, &Port<SHARED>))) -> Self {
        let (address, refused) = (end.address(), end.refused.newest);
        let (end, counts) = (&end.line, end.line.link.counts());
        Self {
            line,
            number: number_on(line),
            address: address.map(|address| address.to_string()),
            lives: end.lives,
            refused: refused.map(|(from, why)| line_wrong(line, from, &why)),
            energy: port.energy(),
            copy_mm: end.heard.map(|said| 1e3 * f64::from(said.object_position)),
            said: end.heard.as_ref().map(RemoteReport::new),
            round_trip_us: end.link.clock().round_trip_us(),
            datagrams_taken: counts.taken,
            datagrams_missing: counts.missing,
            notices: Noticed::all(&end.notices),
        }
    }
}

/// What the hub saw along one of several shared axes.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct AxisReport {
    /// What the axis is called.
    pub axis: &'static str,
    /// Where the lines meet along it, mm from where they met first.
    pub object_mm: f64,
    /// The most, at the end of any exchange, that had gone back into the lines along it beyond what the peers had put in, mJ.
    pub energy_made_mj: f64,
}

/// What the hub saw.
#[derive(Serialize)]
pub struct Report {
    /// Packet periods since all were there.
    pub packets: u64,
    /// The same of all shared axes together, mJ.
    pub energy_made_mj: f64,
    /// Where the lines meet, mm from where they met first; of several shared axes along the first.
    pub object_mm: f64,
    /// Largest distance between two copies as the peers last reported them, mm; they report every half second, not at one instant. Of
    /// several shared axes along the first.
    pub apart_mm: f64,
    /// How far apart all copies truly were, by the peers' telemetry, and where it was recorded; of several shared axes along the first.
    #[serde(flatten)]
    pub seen: LiveSummary,
    /// Each of several shared axes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub axes: Vec<AxisReport>,
    /// Datagrams that no line took: forged, replayed, broken, or of a peer without its line's key.
    pub datagrams_refused: u64,
    /// Who sent the last of them that tells something, and why it was refused.
    pub refused: Option<String>,
    /// What was seen of each line, from line 1 on.
    pub lines: Vec<LineReport>,
    /// How well the hub's control loop kept its ticks.
    pub punctuality: Punctuality,
}

struct HubActor<const SHARED: usize> {
    hub: Hub<SocketAddr, SHARED>,
    listen: SocketAddr,
    patience_s: f64,
    /// Packet periods until it is over.
    packets: u64,
    watch: HubWatch,
}

impl<const SHARED: usize> Actor<SocketAddr> for HubActor<SHARED> {
    type Packet = [u8];

    fn hear(&mut self, now_ns: u64, from: SocketAddr, datagram: &mut [u8], out: &mut Out<'_, SocketAddr, [u8]>) {
        self.hub.receive(now_ns / 1_000, from, datagram, out);
        self.watch.heard(now_ns, &self.hub);
    }

    fn act(&mut self, now_ns: u64, out: &mut Out<'_, SocketAddr, [u8]>) {
        let waited = self.hub.packets.is_none();
        if waited && 1e-9 * now_ns as f64 >= self.patience_s {
            self.hub.begin_without_absent();
        }
        self.hub.tick(now_ns / 1_000, out);
        if waited && self.hub.packets.is_some() {
            match self.absent() {
                absent if absent.is_empty() => {
                    self.watch.teller.words(format!("all {} are there: arm the boards", self.hub.lines().count()));
                }
                absent => self.watch.teller.words(format!("begins without line {}: arm the boards", absent.join(", "))),
            }
        }
        for news in self.hub.news(now_ns / 1_000) {
            self.watch.teller.words(news.to_string());
        }
        self.watch.ticked(now_ns, &self.hub);
    }
}

impl<const SHARED: usize> HubActor<SHARED> {
    /// The lines that nobody is on, and whether somebody was refused there.
    fn absent(&self) -> Vec<String> {
        let absent = (1_u32..).zip(self.hub.lines()).filter(|(_, (end, _))| !end.line.link.is_up());
        let name = |(line, (end, _)): (u32, (&End<SocketAddr, SHARED>, &Port<SHARED>))| {
            let refused = end.refused.newest.map(|(from, why)| format!(": {}", line_wrong(line, from, &why)));
            format!("{line} (peer number {}{})", number_on(line), refused.unwrap_or_default())
        };
        absent.map(name).collect()
    }
}

impl<const SHARED: usize> Live for HubActor<SHARED> {
    fn waited(&mut self, waited: Duration) {
        self.hub.waited(waited.as_micros() as u64);
    }

    fn end(&mut self) -> Option<Result<(), cohold_live::Error>> {
        self.hub.packets.filter(|packets| *packets >= self.packets).map(|_| Ok(()))
    }

    fn missing(&self) -> Option<String> {
        if self.hub.packets.is_some() {
            return None;
        }
        let (Self { listen, patience_s, .. }, users, absent) = (self, self.hub.lines().count(), self.absent());
        let stranger = self.hub.stranger().map(|stranger| format!("; on no line: {stranger}"));
        Some(format!(
            "only {} of {users} peers came within {patience_s} s; nobody on line {} at {listen}, or nobody who holds its key{}",
            users - absent.len(),
            absent.join(", "),
            stranger.unwrap_or_default(),
        ))
    }

    fn goodbye(&mut self, now_ns: u64, out: &mut Out<'_, SocketAddr, [u8]>) {
        self.hub.goodbye(now_ns / 1_000, out);
    }
}

/// Runs the hub to the end, or until it is stopped.
pub fn run(
    scene: &Scene,
    key: &Key,
    users: usize,
    listen: SocketAddr,
    span: Span,
    wanted: &LiveOptions,
    stop: &Stop,
) -> Result<Report, Error> {
    of_axes!(scene, live(scene, key, users, listen, span, wanted, stop))
}

/// The devices, of `N` axes, are the peers'.
fn live<const SHARED: usize, const N: usize>(
    scene: &Scene,
    key: &Key,
    users: usize,
    listen: SocketAddr,
    Span { duration_s, patience_s }: Span,
    wanted: &LiveOptions,
    stop: &Stop,
) -> Result<Report, Error> {
    let timing = &scene.peer.timing;
    let packets = (duration_s / timing.packet_period_s()).round() as u64;
    let endpoint = Endpoint::polled(listen)?;
    let watch = HubWatch::new(wanted, scene, users, endpoint.start(), packets)?;
    let hub = Hub::<_, SHARED>::new(scene, users, key, entropy)?;
    let mut actor = HubActor { hub, listen, patience_s, packets, watch };
    let ticker = Ticker::realtime(Duration::from_secs_f64(timing.control_period_s));
    let punctuality = endpoint.run(ticker, patience_s, stop, &mut actor)?;
    let HubActor { hub, watch, .. } = actor;
    let lines: Vec<LineReport> = (1..).zip(hub.lines()).map(LineReport::new).collect();
    let copies = || lines.iter().filter_map(|line| line.copy_mm);
    let along = |((axis, made_j), motion): ((&'static str, f64), &Motion<f64>)| AxisReport {
        axis,
        object_mm: 1e3 * motion.position,
        energy_made_mj: 1e3 * made_j,
    };
    let axes: Vec<_> = AXIS_NAMES.into_iter().zip(hub.junction.made_j).zip(&hub.junction.motion).map(along).collect();
    Ok(Report {
        packets: hub.packets.unwrap_or(0),
        energy_made_mj: 1e3 * hub.junction.made_j.iter().sum::<f64>(),
        object_mm: axes[0].object_mm,
        apart_mm: copies().reduce(f64::max).unwrap_or(0.0) - copies().reduce(f64::min).unwrap_or(0.0),
        seen: watch.end(),
        axes: if SHARED > 1 { axes } else { Vec::new() },
        datagrams_refused: hub.refused,
        refused: hub.stranger(),
        lines,
        punctuality,
    })
}
