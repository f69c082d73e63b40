//! Who watches a live end: a recording of it, a line each second, and its true discrepancy, all beside the beat.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Instant;

use haptic_core::law::Sends;
use haptic_core::safety::Mode;
use haptic_protocol::link::Notice;
use haptic_protocol::wire::{Flows, Message, Telemetry};
use haptic_sim::node::{Line, Node};
use haptic_sim::report::Made;
use haptic_sim::scene::Scene;
use serde::Serialize;

use super::apart::{Copies, Own, Sum};
use super::tell::{Manner, Second, Teller};
use crate::recording::common_clock::{Relation, Watched};
use crate::recording::mcap::Channel;
use crate::recording::origin::Origin;
use crate::recording::recorder::{Ended, Recorder};
use crate::recording::ticks;
use crate::shared::cooperative::hub::Hub;

/// A clock this well known is what a local network gives, s.
pub(crate) const GOOD_CLOCK_S: f64 = 100e-6;
/// Live ends tell each other so often where their copies are, s: what true discrepancy is measured from.
pub(crate) const TELLING_S: f64 = 0.02;

/// What the command line asks for.
#[derive(Clone, Debug, Default)]
pub(crate) struct Wanted {
    /// Record into this file, with what made it.
    pub(crate) record: Option<(PathBuf, Made)>,
    pub(crate) manner: Manner,
}

impl Wanted {
    /// Begins a recording, if one is wanted, on a clock that began at `start`.
    pub(crate) fn recorder(
        &self,
        who: &str,
        start: Instant,
        channels: Vec<Channel>,
    ) -> Result<Option<Recorder>, String> {
        let create = |(path, made): &(PathBuf, Made)| Recorder::create(path, &Origin::here(made, who, start), channels);
        self.record.as_ref().map(create).transpose()
    }
}

/// How the clocks of two ends stand to each other, as a report has it.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct CommonClock {
    /// The other end's clock less this one's, now.
    offset_us: f64,
    /// By how much that may be wrong.
    error_us: f64,
    drift_ppm: f64,
    drift_error_ppm: f64,
    smallest_round_trip_us: f64,
}

impl CommonClock {
    pub(crate) fn at(relation: &Relation, now_s: f64) -> Self {
        Self {
            offset_us: 1e6 * relation.offset_s(now_s),
            error_us: 1e6 * relation.error_s(now_s),
            drift_ppm: 1e6 * relation.drift,
            drift_error_ppm: 1e6 * relation.drift_error(),
            smallest_round_trip_us: 1e6 * relation.round_trip_s,
        }
    }
}

/// What was seen of one run, as a report has it.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct Seen {
    /// Mean distance of the two copies over the last half, mm, from the other end's telemetry; its largest of all; and by how much the
    /// clocks may make it wrong.
    pub(crate) true_discrepancy_mm: Option<f64>,
    pub(crate) largest_true_discrepancy_mm: Option<f64>,
    pub(crate) true_discrepancy_error_mm: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) common_clock: Option<CommonClock>,
    /// Where it was recorded, and what is missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) recorded: Option<String>,
}

impl Seen {
    fn of(half: &Sum, all: &Sum, common_clock: Option<CommonClock>, recorded: Option<String>) -> Self {
        let mm = |metres: Option<f64>| metres.map(|metres| 1e3 * metres);
        Self {
            true_discrepancy_mm: mm(half.mean_m()),
            largest_true_discrepancy_mm: mm(all.largest_m()),
            true_discrepancy_error_mm: mm(all.error_m()),
            common_clock,
            recorded,
        }
    }
}

/// Records and reports what a hub does.
pub(crate) struct HubWatch {
    recorder: Option<Recorder>,
    pub(crate) teller: Teller,
    period_s: f64,
    packet_s: f64,
    packets: u64,
    clocks: Vec<Watched>,
    told: Vec<Option<u32>>,
    copies: Copies,
    of_second: Sum,
    of_half: Sum,
    of_all: Sum,
    ticks: u64,
    noticed: Vec<u64>,
    row: Vec<f64>,
}

impl HubWatch {
    /// Of so many lines, whose clock began at `start`, and which runs for so many packet periods.
    pub(crate) fn new(
        wanted: &Wanted,
        scene: &Scene,
        lines: usize,
        start: Instant,
        packets: u64,
    ) -> Result<Self, String> {
        let timing = &scene.peer.timing;
        Ok(Self {
            recorder: wanted.recorder("hub", start, ticks::hub_channels(lines))?,
            teller: Teller::new(wanted.manner),
            period_s: timing.control_period_s,
            packet_s: timing.packet_period_s(),
            packets,
            clocks: vec![Watched::default(); lines],
            told: vec![None; lines],
            copies: Copies::new(lines),
            of_second: Sum::default(),
            of_half: Sum::default(),
            of_all: Sum::default(),
            ticks: 0,
            noticed: vec![0; lines],
            row: Vec::new(),
        })
    }

    fn record(&self, channel: u16, time_ns: u64, values: &[f64]) {
        if let Some(recorder) = &self.recorder {
            recorder.put(channel, time_ns, values);
        }
    }

    /// A datagram was taken.
    pub(crate) fn heard(&mut self, now_ns: u64, hub: &Hub<SocketAddr>) {
        for (at, (end, _)) in hub.lines().enumerate() {
            let line = &end.line;
            if let Some(exchange) = self.clocks[at].see(line.link.clock().newest()) {
                let row = ticks::exchange(&exchange, line.link.session_number());
                self.record(ticks::EXCHANGES, now_ns, &[&row[..], &[at as f64 + 1.0]].concat());
                if self.clocks[at].relation.is_none() {
                    self.clocks[at].look();
                }
            }
            let tick = line.heard.as_ref().map(|said| said.tick);
            if let Some(said) = line.heard.as_ref().filter(|_| tick != self.told[at]) {
                let sealed_us = line.link.sealed_us();
                if let Some(apart) = self.copies.told(at, said, sealed_us, self.period_s, &self.clocks[at]) {
                    self.of_second.add(apart);
                    self.of_all.add(apart);
                    if hub.packets.unwrap_or(0) >= self.packets / 2 {
                        self.of_half.add(apart);
                    }
                }
            }
            self.told[at] = tick;
        }
    }

    /// A tick is over.
    pub(crate) fn ticked(&mut self, now_ns: u64, hub: &Hub<SocketAddr>) {
        let time_s = now_ns as f64 * 1e-9;
        self.row.clear();
        self.row.extend([time_s, self.ticks as f64, hub.junction.motion.position]);
        for (_, port) in hub.lines() {
            self.row.extend([port.force_n, port.energy.taken_j, port.energy.sent_j]);
        }
        self.record(ticks::TICKS, now_ns, &self.row);
        self.ticks += 1;
        for ((end, _), (at, told)) in hub.lines().zip(self.noticed.iter_mut().enumerate()) {
            let line = &end.line;
            if line.noticed == *told {
                continue;
            }
            for (time_us, notice) in line.notices.iter().rev().take((line.noticed - *told) as usize).rev() {
                self.teller.notice(*time_us, &format!("line {}: ", at + 1), notice);
                if let Notice::NewPeer(_) = notice {
                    // Another life has another clock.
                    self.clocks[at].forget();
                }
            }
            *told = line.noticed;
        }
        if self.ticks.is_multiple_of((1.0 / self.period_s).round().max(1.0) as u64) {
            self.second(now_ns, time_s, hub);
        }
    }

    fn second(&mut self, now_ns: u64, time_s: f64, hub: &Hub<SocketAddr>) {
        self.clocks.iter_mut().for_each(Watched::look);
        let sum = std::mem::take(&mut self.of_second);
        let up = hub.lines().filter(|(end, _)| end.line.link.is_up()).count();
        let live = hub.lines().filter(|(_, port)| port.is_engaged()).count();
        let error_s =
            self.clocks.iter().filter_map(|clock| Some(clock.relation.as_ref()?.error_s(time_s))).reduce(f64::max);
        let round_trip_us = hub.lines().filter_map(|(end, _)| end.line.link.clock().round_trip_us()).max();
        let fault = (1..).zip(hub.lines()).find_map(|(at, (end, _))| {
            let fault = end.line.heard.as_ref().map_or(0, |said| said.fault);
            (fault != 0).then(|| format!("line {at}: fault {fault}"))
        });
        let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
        let values =
            [time_s, up as f64, number(sum.rms_m()), number(sum.largest_m()), number(sum.error_m()), number(error_s)];
        self.record(ticks::SECONDS, now_ns, &values);
        let mm = |metres: Option<f64>| metres.map(|metres| 1e3 * metres);
        let packets = hub.packets.unwrap_or(0);
        self.teller.second(Second {
            time_s,
            done_s: packets as f64 * self.packet_s,
            of_s: self.packets as f64 * self.packet_s,
            state: if hub.packets.is_some() { "meeting" } else { "waiting" },
            partner: format!("{up} of {} lines", self.clocks.len()),
            round_trip_us,
            true_discrepancy_mm: mm(sum.rms_m()),
            largest_true_discrepancy_mm: mm(sum.largest_m()),
            true_discrepancy_error_mm: mm(sum.error_m()),
            clock_error_us: error_s.map(|error_s| 1e6 * error_s),
            live_share: hub.packets.is_some().then_some(live as f64 / self.clocks.len() as f64),
            fault,
        });
    }

    /// What there was to see; the recording is closed.
    pub(crate) fn end(mut self) -> Seen {
        let recorded = self.recorder.take().map(|recorder| recorder.finish().told());
        if let Some(told) = &recorded {
            self.teller.words(told.clone());
        }
        Seen::of(&self.of_half, &self.of_all, None, recorded)
    }
}

/// Records and reports what a peer does.
pub(crate) struct Watch {
    recorder: Option<Recorder>,
    pub(crate) teller: Teller,
    partner: String,
    period_s: f64,
    /// Ticks of the experiment.
    ticks: u64,
    counts_ticks: bool,
    patience: u32,
    clock: Watched,
    lives: u64,
    own: Own,
    of_second: Sum,
    of_half: Sum,
    of_all: Sum,
    /// Ticks since the last packet, and how long the line has lived, in ticks.
    silent: u32,
    live_ticks: u32,
    /// Ticks of this second, and those in which the line lived.
    of_this: [u32; 2],
    all_ticks: u64,
    told: u64,
}

impl Watch {
    /// Of peer `number`, whose clock began at `start`.
    pub(crate) fn new(
        wanted: &Wanted,
        scene: &Scene,
        number: u8,
        start: Instant,
        partner: String,
        ticks: u64,
    ) -> Result<Self, String> {
        let channels = ticks::channels(&format!("peer_{number}"), scene.peer.axis.shared as usize);
        let timing = &scene.peer.timing;
        Ok(Self {
            recorder: wanted.recorder(&format!("peer {number}"), start, channels)?,
            teller: Teller::new(wanted.manner),
            partner,
            period_s: timing.control_period_s,
            ticks,
            counts_ticks: scene.law().sends == Sends::Counters,
            patience: timing.ticks_per_packet,
            clock: Watched::default(),
            lives: 0,
            own: Own::default(),
            of_second: Sum::default(),
            of_half: Sum::default(),
            of_all: Sum::default(),
            silent: u32::MAX,
            live_ticks: 0,
            of_this: [0; 2],
            all_ticks: 0,
            told: 0,
        })
    }

    /// A datagram was taken; whether it brought flow.
    pub(crate) fn heard<const SHARED: usize>(&mut self, now_ns: u64, line: &Line<SHARED>, flow: bool) {
        if flow {
            self.silent = 0;
        }
        if line.lives != self.lives {
            self.lives = line.lives;
            self.clock.forget();
        }
        if let Some(exchange) = self.clock.see(line.link.clock().newest()) {
            self.record(ticks::EXCHANGES, now_ns, &ticks::exchange(&exchange, line.link.session_number()));
            if self.clock.relation.is_none() {
                self.clock.look();
            }
        }
    }

    /// The other end has sent its telemetry.
    pub(crate) fn said(&mut self, said: &Telemetry, sealed_us: u64, armed_ticks: u64) {
        let Some(apart) = self.own.apart(said, sealed_us, self.period_s, &self.clock) else { return };
        self.of_second.add(apart);
        self.of_all.add(apart);
        if armed_ticks >= self.ticks / 2 {
            self.of_half.add(apart);
        }
    }

    fn record(&self, channel: u16, time_ns: u64, values: &[f64]) {
        if let Some(recorder) = &self.recorder {
            recorder.put(channel, time_ns, values);
        }
    }

    /// A tick is over.
    pub(crate) fn ticked<const SHARED: usize, const N: usize>(&mut self, now_ns: u64, node: &Node<SHARED, N>)
    where
        Flows<SHARED>: Into<Message>,
    {
        // All axes count the same.
        let live_ticks = node.peer.outgoing()[0].live_ticks;
        let live = if self.counts_ticks { live_ticks != self.live_ticks } else { self.silent < self.patience };
        (self.live_ticks, self.silent) = (live_ticks, self.silent.saturating_add(1));
        let mode = node.peer.mode();
        for (axis, (seen, ledger)) in node.peer.observed().into_iter().zip(node.peer.ledger()).enumerate() {
            let energies = [ledger.received_j(), ledger.sent_j()];
            let row = ticks::tick(now_ns, self.all_ticks, mode, seen, energies, live);
            self.record(ticks::of_axis(axis, ticks::SECONDS), now_ns, &row);
        }
        self.all_ticks += 1;
        if mode == Mode::Armed {
            self.own.is_at(now_ns as f64 * 1e-9, node.observed().object.position.into());
        } else {
            self.own.forget();
        }
        self.of_this[0] += 1;
        self.of_this[1] += u32::from(live);
        let line = &node.line;
        let new = line.noticed - self.told;
        for (time_us, notice) in line.notices.iter().rev().take(new as usize).rev() {
            self.teller.notice(*time_us, "", notice);
        }
        self.told = line.noticed;
        if f64::from(self.of_this[0]) * self.period_s >= 1.0 {
            self.second(now_ns, node);
        }
    }

    fn second<const SHARED: usize, const N: usize>(&mut self, now_ns: u64, node: &Node<SHARED, N>) {
        self.clock.look();
        let (time_s, link, sum) = (now_ns as f64 * 1e-9, &node.line.link, std::mem::take(&mut self.of_second));
        let [ticks, live] = std::mem::take(&mut self.of_this);
        let (relation, live_share) = (self.clock.relation.as_ref(), f64::from(live) / f64::from(ticks));
        let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
        let of_clock = ticks::relation(time_s, relation);
        let values = [number(sum.rms_m()), number(sum.largest_m()), number(sum.error_m()), live_share];
        let missing = f64::from(link.counts().missing);
        self.record(ticks::SECONDS, now_ns, &[&of_clock[..], &values, &[missing]].concat());
        let mm = |metres: Option<f64>| metres.map(|metres| 1e3 * metres);
        let (state, fault) = match node.peer.mode() {
            Mode::Faulted(fault) => ("faulted", Some(format!("fault {}: {}", fault.number(), fault.explain()))),
            Mode::Armed => ("armed", None),
            _ if link.is_up() => ("waiting", None),
            _ => ("calling", None),
        };
        self.teller.second(Second {
            time_s,
            done_s: node.armed_ticks as f64 * self.period_s,
            of_s: self.ticks as f64 * self.period_s,
            state,
            partner: self.partner.clone(),
            round_trip_us: link.clock().round_trip_us(),
            true_discrepancy_mm: mm(sum.rms_m()),
            largest_true_discrepancy_mm: mm(sum.largest_m()),
            true_discrepancy_error_mm: mm(sum.error_m()),
            clock_error_us: relation.map(|relation| 1e6 * relation.error_s(time_s)),
            live_share: link.is_up().then_some(live_share),
            fault,
        });
    }

    /// What there was to see; the recording is closed.
    pub(crate) fn end(mut self, now_s: f64) -> Seen {
        self.clock.look();
        let clock = self.clock.relation.as_ref().map(|relation| CommonClock::at(relation, now_s));
        if let Some(clock) = clock.filter(|clock| clock.error_us > 1e6 * GOOD_CLOCK_S) {
            let CommonClock { error_us, smallest_round_trip_us, .. } = clock;
            self.teller.words(format!(
                "the clocks of the two ends are known to {:.2} ms only, not to 0.1 ms as on a local network: half of the smallest \
                 round trip ({:.2} ms) cannot be told from a difference of the two ways",
                1e-3 * error_us,
                1e-3 * smallest_round_trip_us
            ));
        }
        let recorded = self.recorder.take().map(Recorder::finish);
        if let Some(ended) = &recorded {
            self.teller.words(ended.told());
        }
        Seen::of(&self.of_half, &self.of_all, clock, recorded.as_ref().map(Ended::told))
    }
}
