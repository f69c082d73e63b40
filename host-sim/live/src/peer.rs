//! One peer in real time: a [`Node`] on an endpoint. What was heard in a packet period goes into the exchange at its end, newest
//! flow only. It arms when the other one is there and, where somebody judges its scene ([`super::verdict`]), when the verdict lets it.
//!
//! [`run`] gives it a clock. A program that has one of its own gives it turns ([`Endpoint::turn`]), as the page does.

use std::{net::SocketAddr, time::Duration};

use cohold_core::safety::Mode;
use cohold_protocol::key::Key;
use cohold_protocol::link::Error;
use cohold_protocol::path::Path;
use cohold_protocol::wire::Telemetry;
use cohold_sim::device::Device;
use cohold_sim::engine::{Actor, Out};
use cohold_sim::measure::port::{ObjectPort, PortEnergy};
use cohold_sim::measure::{LastHalf, Statistics};
use cohold_sim::peers::Builds;
use cohold_sim::run::AXIS_NAMES;
use cohold_sim::{of_axes, scene::Scene};

mod report;

use super::endpoint::{Endpoint, Live, NO_PRIORITY, Span, Stop, Ticker};
use super::steering::Steered;
use super::verdict::Judging;
use super::watch::{LiveOptions, TELLING_S, Watch};
use crate::devices::Seen;
use crate::refused::{Refused, is_telling, wrong};
use crate::{key_file::entropy, node::Node, start::AFTER_US, tell::Noticed};
pub use report::{AxisReport, Forces, Ports, RemoteReport, Report};

/// How long a peer that refuses the other one, or whose device is gone, goes on, so that the other learns of it as well, µs.
const LINGER_US: u64 = 500_000;

/// Which peer this is, and where the other one is.
#[derive(Debug)]
pub struct OneEnd {
    /// 1 (left) or 2 (right).
    pub number: u8,
    /// The same at both ends.
    pub key: Key,
    /// Where the other one listens; none, and it calls here.
    pub other: Option<SocketAddr>,
}

/// The other end: at its address, or where it has called from.
#[derive(Default)]
pub struct Other {
    name: String,
    at: Option<SocketAddr>,
    path: Path<SocketAddr>,
    /// The line to it is cut, both ways.
    pub cut: bool,
}

impl Other {
    /// Sends what the link says, which may answer a datagram from there.
    fn say(&mut self, bytes: &[u8], answers: Option<SocketAddr>, out: &mut Out<'_, SocketAddr, [u8]>) {
        let to = self.at.or_else(|| self.path.of(bytes, answers));
        if let Some(to) = to.filter(|_| !self.cut) {
            out(to, bytes);
        }
    }
}

/// One peer that shares the object along `SHARED` axes of its device of `N`.
pub struct LivePeer<const SHARED: usize, const N: usize> {
    /// The peer, its device and its link.
    pub node: Node<SHARED, N, dyn Device<f32, N>>,
    /// The other end.
    pub other: Other,
    patience_s: f64,
    /// A tick, s.
    period_s: f64,
    /// Ticks of the experiment.
    ticks: u64,
    /// Along each axis |x_o − x_d|, F_T, F_LC and its square.
    halves: [LastHalf<4>; SHARED],
    /// The distance of the copies; the wall's force and its square.
    whole: LastHalf<3>,
    ports: [ObjectPort; SHARED],
    /// Who sent the newest datagram that was refused and tells something, and why it was.
    refusal: Option<(SocketAddr, Error)>,
    /// Who said what cannot be.
    impossible: Refused<SocketAddr>,
    /// The other peer has other parameters: which table differs, and when that was found, µs.
    differs: Option<(&'static str, u64)>,
    /// When its device was gone, µs.
    gone_us: Option<u64>,
    /// For so long now, µs.
    now_us: u64,
    /// Its recording, and what it says.
    pub watch: Watch,
    /// Whether it may arm.
    pub judging: Option<Judging>,
    /// Position of the other copy minus that of this one when the other end reported it last, m.
    pub offset_m: f64,
    /// A verdict or a path is new; who has taken note of it sets this back.
    pub has_news: bool,
    /// What is seen of a device that is not the scene's.
    device: Option<Seen>,
    /// Since when it may not, if it has never been armed, µs.
    refused_us: Option<u64>,
    /// How long it waits then, s.
    duration_s: f64,
    /// Tick of the newest telemetry.
    reported_tick: Option<u32>,
    /// Who steers it.
    steering: Option<Steered<SHARED>>,
    /// Since when it is wanted armed, µs.
    wanted_us: Option<u64>,
}

impl<const SHARED: usize, const N: usize> LivePeer<SHARED, N>
where
    f32: Builds<SHARED, N>,
{
    /// Calls the other one, or waits for it, over this endpoint. Its device is opened last, and from here on read at every tick.
    ///
    /// # Errors
    /// A scene that cannot be built or recorded, or a device that does not open.
    pub fn open(
        scene: &Scene,
        OneEnd { number, key, other }: OneEnd,
        endpoint: &Endpoint,
        Span { duration_s, patience_s }: Span,
        wanted: &LiveOptions,
    ) -> Result<Self, crate::Error> {
        let entropy = entropy()?;
        let period_s = scene.peer.timing.control_period_s;
        let ticks = (duration_s / period_s).round() as u64;
        // What has no end has no last half.
        let measured = if duration_s.is_finite() { ticks } else { 0 };
        let name = other.map_or_else(|| "the other end".to_owned(), |at| at.to_string());
        let other = Other { name, at: other, ..Other::default() };
        let judging = wanted.judge.as_ref().map(|judge| Judging::start(judge, period_s)).transpose()?;
        let length = (measured, endpoint.road());
        let watch = Watch::new(wanted, scene, number, endpoint.start(), other.name.clone(), length)?;
        let (opened, device) = wanted.device.open(scene, number)?;
        let judging = judging.map(|judging| judging.of_device(device.clone()));
        let node =
            Node::with_device(scene, number, key, entropy, opened)?.telling_every(TELLING_S).beginning_after(AFTER_US);
        Ok(Self {
            judging,
            offset_m: 0.0,
            has_news: false,
            device,
            refused_us: None,
            duration_s,
            watch,
            reported_tick: None,
            steering: wanted.steering.clone().map(Steered::new),
            wanted_us: Some(0),
            node,
            other,
            patience_s,
            period_s,
            ticks,
            halves: [LastHalf::new(measured); SHARED],
            whole: LastHalf::new(measured),
            ports: [ObjectPort::new(period_s, scene.peer.coordination.stiffness_n_per_m); SHARED],
            refusal: None,
            impossible: Refused::default(),
            differs: None,
            gone_us: None,
            now_us: 0,
        })
    }
}

impl<const SHARED: usize, const N: usize> LivePeer<SHARED, N> {
    /// Where the hand is that somebody steers, m, if it holds the device, and its force on that in the last tick, N, along each shared axis.
    pub fn hand(&self) -> (Option<[f64; SHARED]>, [f64; SHARED]) {
        self.steering.as_ref().map_or((None, [0.0; SHARED]), |steered| (steered.hand.holds(), steered.pulled_n))
    }

    /// Energy that its coordination took in and neither gave out nor stores, J, along all axes; below 0 it has generated energy.
    pub fn kept_j(&self) -> f64 {
        self.ports.iter().map(ObjectPort::kept_j).sum()
    }

    /// Keeps the motors off until the verdict, and whoever steers, let them be armed. Once they are, no verdict turns them off.
    fn heed(&mut self) {
        let held = self.steer();
        if let Some(words) = self.judging.as_mut().and_then(|judging| judging.heed(self.now_us, &mut self.node, held)) {
            self.watch.teller.words(words);
            self.has_news = true;
        }
        let mode = self.node.peer.mode();
        let unjudged = self.judging.is_none() && mode == Mode::Disarmed && self.node.is_halted() != held;
        if unjudged || mode == Mode::Armed && held {
            self.node.halt(held);
        }
        let refuses = self.judging.as_ref().is_some_and(|judging| judging.refuses().is_some());
        let refused = mode == Mode::Disarmed && self.node.armed_ticks == 0 && refuses;
        self.refused_us = refused.then(|| self.refused_us.unwrap_or(self.now_us));
    }

    /// Does what is wanted; whether its motors are to be off.
    fn steer(&mut self) -> bool {
        let Some(steered) = &mut self.steering else { return false };
        let wanted = steered.heed(&mut self.node, self.period_s);
        self.wanted_us = wanted.armed.then(|| self.wanted_us.unwrap_or(self.now_us));
        !wanted.armed
    }

    fn differs_in(&self, table: &str) -> String {
        format!("{} was told other parameters: table [{table}] of the scene differs", self.other.name)
    }
}

impl<const SHARED: usize, const N: usize> Actor<SocketAddr> for LivePeer<SHARED, N> {
    type Packet = [u8];

    fn hear(&mut self, now_ns: u64, from: SocketAddr, datagram: &mut [u8], out: &mut Out<'_, SocketAddr, [u8]>) {
        if self.other.cut {
            return;
        }
        let now_us = now_ns / 1_000;
        let taken = self.node.receive(now_us, datagram);
        self.other.path.heard(now_us, from, datagram, taken.is_ok(), &self.node.line.link);
        // What is refused is counted by the link, too.
        match taken {
            Ok(flow) => {
                let line = &self.node.line;
                self.watch.heard(now_ns, line, flow.is_some());
                if let Some(judging) = &mut self.judging {
                    judging.see(line.link.clock().newest());
                }
                let tick = line.heard.as_ref().map(|said| said.tick);
                if let Some(said) = line.heard.as_ref().filter(|_| tick != self.reported_tick) {
                    let apart = self.watch.said(said, line.link.sealed_us(), self.node.armed_ticks);
                    // Before both move and the clocks are known, the copies are where they are said to be.
                    let now_m = || f64::from(said.object_position) - f64::from(self.node.observed().object.position);
                    self.offset_m = apart.map_or_else(now_m, |apart| apart.offset_m);
                }
                self.reported_tick = tick;
                self.node.line.link.say_due(now_us, |bytes| self.other.say(bytes, Some(from), out));
            }
            Err(why @ Error::Impossible(_)) => self.impossible.note(from, why),
            Err(why) if is_telling(&why) => self.refusal = Some((from, why)),
            Err(_) => {}
        }
    }

    fn act(&mut self, now_ns: u64, out: &mut Out<'_, SocketAddr, [u8]>) {
        self.now_us = now_ns / 1_000;
        self.heed();
        let node = &mut self.node;
        let actuators = node.tick(self.now_us, |bytes| self.other.say(bytes, None, out));
        if let (None, Some(gone)) = (self.gone_us, node.gone()) {
            self.gone_us = Some(self.now_us);
            self.watch.teller.words(format!("the motors are off: {gone}"));
        }
        let since_us = self.differs.map_or(self.now_us, |(_, since_us)| since_us);
        self.differs = node.line.link.refused().map(|table| (table, since_us));
        if let Some(tick) = node.armed_ticks.checked_sub(1) {
            let mut decoded_m: f64 = 0.0;
            let axes = node.peer.observed().into_iter().map(|seen| seen.map(f64::from));
            let booked =
                node.peer.ledger().into_iter().map(|booked| [booked.received_j(), booked.sent_j()].map(f64::from));
            for ((seen, booked), (half, port)) in axes.zip(booked).zip(self.halves.iter_mut().zip(&mut self.ports)) {
                let discrepancy_m = (seen.object.position - seen.desired.position).abs();
                let contact_n = seen.contact_force;
                half.see(tick, [discrepancy_m, seen.coordination_force, contact_n, contact_n * contact_n]);
                port.see(&seen, booked);
                decoded_m = decoded_m.hypot(discrepancy_m);
            }
            let wall_n = node.wall_n();
            self.whole.see(tick, [decoded_m, wall_n, wall_n * wall_n]);
        }
        self.has_news |= self.watch.ticked(now_ns, node, self.judging.as_ref());
        if let Some(Steered { steering, .. }) = &self.steering {
            let forces = if actuators.enable { actuators.forces } else { [0.0; N] };
            steering.leave(now_ns, (&*node, forces), (self.watch.newest.as_ref(), self.judging.as_ref()));
        }
        if let Some((from, why)) = self.impossible.take(self.now_us) {
            self.watch.teller.words(wrong(from, &why));
        }
    }
}

impl<const SHARED: usize, const N: usize> Live for LivePeer<SHARED, N> {
    fn waited(&mut self, waited: Duration) {
        self.node.line.link.waited(waited.as_micros() as u64);
    }

    fn end(&mut self) -> Option<Result<(), crate::Error>> {
        let waited_s = self.refused_us.map(|since_us| 1e-6 * (self.now_us - since_us) as f64);
        let waited = waited_s.is_some_and(|waited_s| waited_s >= self.duration_s);
        let gone = self.gone_us.is_some_and(|gone_us| self.now_us >= gone_us + LINGER_US);
        let over = (waited || gone || self.node.armed_ticks >= self.ticks).then_some(Ok(()));
        let overdue = self.differs.filter(|(_, since_us)| self.now_us >= since_us + LINGER_US);
        overdue.map(|(table, _)| Err(self.differs_in(table).into())).or(over)
    }

    fn missing(&self) -> Option<String> {
        let (other, patience_s) = (&self.other.name, self.patience_s);
        if let Some((table, _)) = self.differs {
            return Some(self.differs_in(table));
        }
        if self.refused_us.is_some() || self.gone_us.is_some() {
            return None;
        }
        let wanted_us = self.wanted_us?;
        if self.now_us < wanted_us.saturating_add((1e6 * patience_s) as u64) && wanted_us > 0 {
            return None;
        }
        let off = |said: &Telemetry| said.mode == 0;
        (!self.node.is_moving() && self.node.armed_ticks == 0).then(|| match self.node.line.link.is_up() {
            true if self.node.is_halted() => format!(
                "{other} is there, but what this scene is over so long a line was not known within {patience_s} s"
            ),
            true if self.node.peer.mode() == Mode::Armed && self.node.line.heard.as_ref().is_some_and(off) => {
                format!("{other} is there, but did not arm within {patience_s} s: that end says why")
            }
            true if self.node.peer.mode() == Mode::Armed => format!(
                "{other} is there, but not both ends of the line were live within {patience_s} s: a hub waits until all its lines are"
            ),
            true => format!(
                "{other} is there, but sent no flow within {patience_s} s: a hub waits until all its peers are there"
            ),
            false => match &self.refusal {
                Some((from, why)) => wrong(from, why),
                None => {
                    format!("nobody answered from {other} within {patience_s} s: is it there, and does it send here?")
                }
            },
        })
    }

    fn goodbye(&mut self, now_ns: u64, out: &mut Out<'_, SocketAddr, [u8]>) {
        self.node.goodbye(now_ns / 1_000, |bytes| self.other.say(bytes, None, out));
    }
}

/// Runs peer 1 (left) or 2 (right), which listens at the first address while the other listens at the second, to the end of its
/// experiment, or until it is stopped. Where the two meet somewhere ([`LiveOptions::meeting`]), the second address is that of the place.
pub fn run(
    scene: &Scene,
    key: Key,
    number: u8,
    ends: [SocketAddr; 2],
    span: Span,
    wanted: &LiveOptions,
    stop: &Stop,
) -> Result<Report, crate::Error> {
    of_axes!(scene, live((scene, key, number), ends, span, wanted, stop))
}

fn live<const SHARED: usize, const N: usize>(
    (scene, key, number): (&Scene, Key, u8),
    [listen, connect]: [SocketAddr; 2],
    span: Span,
    wanted: &LiveOptions,
    stop: &Stop,
) -> Result<Report, crate::Error>
where
    f32: Builds<SHARED, N>,
{
    let endpoint = match &wanted.meeting {
        Some(meeting) => meeting.open(Some(listen), key.clone(), number - 1)?,
        None => Endpoint::polled(listen)?,
    };
    endpoint.reaches(connect)?;
    let end = OneEnd { number, key, other: Some(connect) };
    let mut peer = LivePeer::<SHARED, N>::open(scene, end, &endpoint, span, wanted)?;
    if let Some(steering) = &wanted.steering {
        steering.begin();
    }
    let ticker = Ticker::realtime(Duration::from_secs_f64(peer.period_s));
    if !ticker.kept.realtime_priority {
        peer.watch.teller.words(NO_PRIORITY.to_owned());
    }
    let punctuality = endpoint.run(ticker, span.patience_s, stop, &mut peer)?;
    let LivePeer { node, halves, whole, ports, watch, judging, refused_us, device, .. } = peer;
    let (verdict, verdicts) = judging.map_or_else(Default::default, |judging| (judging.verdict, judging.said));
    let [decoded_m, wall, wall_squared] = whole.means();
    let along = |(axis, half): (&'static str, &LastHalf<4>)| {
        let [discrepancy_m, coordination_force_n, contact, contact_squared] = half.means();
        let contact_force_n = Statistics::of_moments(contact, contact_squared);
        let forces = Forces { coordination_force_n, contact_force_n };
        AxisReport { axis, decoded_discrepancy_mm: 1e3 * discrepancy_m, forces }
    };
    let axes: Vec<AxisReport> = AXIS_NAMES.into_iter().zip(&halves).map(along).collect();
    let energies = ports.iter().zip(node.peer.ledger());
    let energies = energies.map(|(port, booked)| port.with_network(booked.received_j().into(), booked.sent_j().into()));
    let energy: PortEnergy = energies.sum();
    // What is in joules among a law's keys it may give before it has taken anything, along each axis.
    let starts = scene.law().keys.iter().filter(|key| key.unit == "J").map(|key| scene.peer.own(key));
    let start_j = SHARED as f64 * starts.sum::<f64>();
    let (line, link) = (&node.line, &node.line.link);
    let counts = link.counts();
    Ok(Report {
        peer: number,
        ticks: node.armed_ticks,
        decoded_discrepancy_mm: 1e3 * decoded_m,
        seen: watch.end(endpoint.now_ns() as f64 * 1e-9),
        forces: axes[0].forces,
        axes: if SHARED > 1 { axes } else { Vec::new() },
        wall_force_n: (scene.users[usize::from(number == 2)].has_wall())
            .then(|| Statistics::of_moments(wall, wall_squared)),
        port_energy: Ports { energy, least_balance_j: start_j - energy.made_j },
        fault: node.fault(),
        verdict,
        verdicts,
        refused: refused_us.is_some(),
        notices: Noticed::all(&line.notices),
        round_trip_us: link.clock().round_trip_us(),
        jitter_us: link.clock().jitter_us(),
        clock_offset_us: link.clock().offset_us(endpoint.now_ns() / 1_000),
        clock_drift_ppm: link.clock().drift_ppm(),
        other: line.heard.as_ref().map(RemoteReport::new),
        datagrams_taken: counts.taken,
        datagrams_missing: counts.missing,
        datagrams_refused: counts.refused,
        path: endpoint.road().map(|road| road.report()),
        punctuality,
        device: device.and_then(|seen| seen.report()),
    })
}
