//! Who watches a live end: a recording of it, a line each second, and its true discrepancy, all beside the beat.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use cohold_core::safety::Mode;
use cohold_core::sample::OfPeer;
use cohold_protocol::wire::Telemetry;
use cohold_report::Provenance;
use cohold_sim::device::Device;
use cohold_sim::scene::Scene;
use serde::Serialize;

use super::devices::DeviceOptions;
use super::discrepancy::{Discrepancy, PositionHistory, Sum};
use super::path_watch::PathWatch;
use super::road::{PathReport, Road, Roads};
use super::steering::Steering;
use super::tell::{Manner, PathSecond, Second, Teller};
use super::verdict::{Judge, Judging, state};
use crate::Error;
use crate::node::{Line, Node};
use crate::recording::common_clock::{Relation, Watched};
use crate::recording::mcap::Channel;
use crate::recording::origin::Origin;
use crate::recording::recorder::{Ended, Recorder};
use crate::recording::ticks;

/// A clock this well known is what a local network gives, s.
pub const GOOD_CLOCK_S: f64 = 100e-6;
/// Live ends tell each other so often where their copies are, s: what true discrepancy is measured from.
pub const TELLING_S: f64 = 0.02;

/// What the command line asks for.
#[derive(Clone, Debug, Default)]
pub struct LiveOptions {
    /// Record into this file, with what made it.
    pub record: Option<(PathBuf, Provenance)>,
    /// How lines are said while it runs.
    pub manner: Manner,
    /// Judges a peer's scene at the delays that it measures; without it a peer arms as soon as it hears the other one.
    pub judge: Option<Judge>,
    /// The device that a peer has.
    pub device: DeviceOptions,
    /// Where a peer meets the other one, which it does not call at an address.
    pub meeting: Option<Arc<dyn Roads>>,
    /// Who reads and steers a peer from this process; without it a peer arms by itself.
    pub steering: Option<Arc<Steering>>,
}

impl LiveOptions {
    /// Begins a recording, if one is wanted, on a clock that began at `start`.
    pub fn recorder(&self, who: &str, start: Instant, channels: Vec<Channel>) -> Result<Option<Recorder>, Error> {
        let create = |(path, provenance): &(PathBuf, Provenance)| {
            Recorder::create(path, &Origin::here(provenance, who, start), channels)
        };
        self.record.as_ref().map(create).transpose()
    }
}

/// How the clocks of two ends stand to each other, as a report has it.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct CommonClock {
    /// The other end's clock less this one's, now.
    offset_us: f64,
    /// By how much that may be wrong.
    error_us: f64,
    drift_ppm: f64,
    drift_error_ppm: f64,
    smallest_round_trip_us: f64,
}

impl CommonClock {
    /// From the relation of the two clocks, when this end's own clock shows `now_s`, s.
    pub fn at(relation: &Relation, now_s: f64) -> Self {
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
pub struct LiveSummary {
    /// Mean distance of the two copies over the last half, mm, from the other end's telemetry; its largest of all; and by how much the
    /// clocks may make it wrong.
    pub true_discrepancy_mm: Option<f64>,
    /// Largest distance of the copies in the whole run, mm.
    pub largest_true_discrepancy_mm: Option<f64>,
    /// Largest error of a distance of the copies that the clocks may cause, mm.
    pub true_discrepancy_error_mm: Option<f64>,
    /// How the clocks stood at the end of the run; absent in a hub's report, and where no exchange was completed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub common_clock: Option<CommonClock>,
    /// Where it was recorded, and what is missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recorded: Option<String>,
}

impl LiveSummary {
    /// From the distances of the last half and of the whole run, with the clocks and the recording, if there are any.
    pub fn of(half: &Sum, all: &Sum, common_clock: Option<CommonClock>, recorded: Option<String>) -> Self {
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

/// Who records as peer `number`.
pub fn who(number: u8) -> String {
    format!("peer {number}")
}

/// The channels that a recording of peer `number` of this scene has; the last is that of its paths, where it `meets` the other one somewhere.
pub fn channels(scene: &Scene, number: u8, meets: bool) -> Vec<Channel> {
    let of = format!("peer_{number}");
    let paths = meets.then(|| ticks::path_channel(&of));
    ticks::channels(&of, scene.peer.axis.shared as usize).into_iter().chain(paths).collect()
}

/// Whether what a peer hears is fresh. A law whose line counts its own time lives while its counter moves; another one while packets come.
#[derive(Clone, Copy, Debug, Default)]
pub struct Liveness {
    counts_ticks: bool,
    patience: u32,
    silent: u32,
    live_ticks: u32,
}

impl Liveness {
    /// Of a peer that has heard nothing yet.
    pub fn of(scene: &Scene) -> Self {
        let (counts_ticks, patience) = (scene.law().own_time, scene.peer.timing.ticks_per_packet);
        Self { counts_ticks, patience, silent: u32::MAX, live_ticks: 0 }
    }

    /// After a tick, in which it heard a packet or not and sent this count.
    pub fn see(&mut self, heard: bool, live_ticks: u32) -> bool {
        self.silent = if heard { 0 } else { self.silent.saturating_add(1) };
        let moved = std::mem::replace(&mut self.live_ticks, live_ticks) != live_ticks;
        if self.counts_ticks { moved } else { self.silent < self.patience }
    }
}

/// Records and reports what a peer does.
#[derive(Debug, Default)]
pub struct Watch {
    recorder: Option<Arc<Recorder>>,
    pub(crate) teller: Teller,
    partner: String,
    period_s: f64,
    /// Ticks of the experiment.
    ticks: u64,
    /// Mode and fault that the log has said last.
    mode: [f64; 2],
    clock: Watched,
    lives: u64,
    own: PositionHistory,
    of_second: Sum,
    of_half: Sum,
    of_all: Sum,
    /// What it heard is fresh, or its line lives.
    pub live: bool,
    liveness: Liveness,
    has_flow: bool,
    /// Ticks of this second, and those in which the line lived.
    of_this: [u32; 2],
    all_ticks: u64,
    reported: u64,
    /// The newest second.
    pub(crate) newest: Option<Second>,
    /// The paths of a line that is carried.
    paths: Option<PathWatch>,
}

impl Watch {
    /// Of peer `number`, whose clock began at `start`.
    pub(crate) fn new(
        wanted: &LiveOptions,
        scene: &Scene,
        number: u8,
        start: Instant,
        partner: String,
        (ticks, road): (u64, Option<Arc<dyn Road>>),
    ) -> Result<Self, Error> {
        let channels = channels(scene, number, road.is_some());
        let recorder = wanted.recorder(&who(number), start, channels)?.map(Arc::new);
        let mut watch = Self {
            partner,
            ticks,
            paths: road.map(PathWatch::new),
            teller: Teller::new(wanted.manner),
            period_s: scene.peer.timing.control_period_s,
            liveness: Liveness::of(scene),
            ..Self::default()
        };
        if let Some(recorder) = recorder {
            watch.record_into(recorder, scene);
        }
        Ok(watch)
    }

    /// Records from now on into a recording whose first channels are [`channels`], on the clock of the peer's endpoint.
    pub fn record_into(&mut self, recorder: Arc<Recorder>, scene: &Scene) {
        let channel = ticks::paths(scene.peer.axis.shared as usize);
        self.paths = self.paths.take().map(|paths| paths.recording(Arc::clone(&recorder), channel));
        self.teller.log = Some(Arc::clone(&recorder));
        self.recorder = Some(recorder);
    }

    /// What the paths of a carried line are like.
    pub fn paths(&self) -> Option<PathReport> {
        self.paths.as_ref().map(PathWatch::report)
    }

    /// A datagram was taken; whether it brought flow.
    pub fn heard<const SHARED: usize>(&mut self, now_ns: u64, line: &Line<SHARED>, flow: bool) {
        self.has_flow |= flow;
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

    /// The other end has sent its telemetry: how far its copy was from this one, if both moved and the clocks are known.
    pub fn said(&mut self, said: &Telemetry, sealed_us: u64, armed_ticks: u64) -> Option<Discrepancy> {
        let discrepancy = self.own.discrepancy(said, sealed_us, self.period_s, &self.clock)?;
        self.of_second.add(discrepancy);
        self.of_all.add(discrepancy);
        if armed_ticks >= self.ticks / 2 {
            self.of_half.add(discrepancy);
        }
        Some(discrepancy)
    }

    fn record(&self, channel: u16, time_ns: u64, values: &[f64]) {
        if let Some(recorder) = &self.recorder {
            recorder.put(channel, time_ns, values);
        }
    }

    /// A tick is over; whether the line's path has changed.
    pub fn ticked<const SHARED: usize, const N: usize, D: Device<f32, N> + ?Sized>(
        &mut self,
        now_ns: u64,
        node: &Node<SHARED, N, D>,
        judging: Option<&Judging>,
    ) -> bool {
        // All axes count the same.
        let live = self.liveness.see(std::mem::take(&mut self.has_flow), node.peer.outgoing()[0].live_ticks);
        self.live = live;
        let mode = node.peer.mode();
        let mut peer = OfPeer::new(self.all_ticks, mode);
        [peer.mode, peer.fault] = node.mode_and_fault();
        if let Some(recorder) = &self.recorder {
            recorder.log_mode(now_ns, &recorder.who, &mut self.mode, [peer.mode, peer.fault].map(f64::from));
        }
        for (axis, (seen, ledger)) in node.peer.observed().into_iter().zip(node.peer.ledger()).enumerate() {
            let energies = [ledger.received_j(), ledger.sent_j()];
            let row = ticks::tick(now_ns, peer, seen, energies, live);
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
        let new = line.noticed - self.reported;
        for (time_us, notice) in line.notices.iter().rev().take(new as usize).rev() {
            self.teller.notice(*time_us, "", notice);
        }
        self.reported = line.noticed;
        let path_changed = self.paths.as_ref().is_some_and(|paths| paths.look(now_ns, &self.teller));
        if f64::from(self.of_this[0]) * self.period_s >= 1.0 {
            self.second(now_ns, node, judging);
        }
        path_changed
    }

    fn second<const SHARED: usize, const N: usize, D: Device<f32, N> + ?Sized>(
        &mut self,
        now_ns: u64,
        node: &Node<SHARED, N, D>,
        judging: Option<&Judging>,
    ) {
        self.clock.look();
        let (time_s, link, sum) = (now_ns as f64 * 1e-9, &node.line.link, std::mem::take(&mut self.of_second));
        let [ticks, live] = std::mem::take(&mut self.of_this);
        let (relation, live_share) = (self.clock.relation.as_ref(), f64::from(live) / f64::from(ticks));
        let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
        let of_clock = ticks::relation(time_s, relation);
        let values = [number(sum.rms_m()), number(sum.largest_m()), number(sum.error_m()), live_share];
        let missing = f64::from(link.counts().missing);
        let stable = judging.and_then(|judging| judging.verdict.as_ref()?.stable);
        let stands = [missing, number(stable.map(|stable| f64::from(u8::from(stable))))];
        self.record(ticks::SECONDS, now_ns, &[&of_clock[..], &values, &stands].concat());
        let report = self.paths.as_ref().map(|paths| paths.second(now_ns));
        let mm = |metres: Option<f64>| metres.map(|metres| 1e3 * metres);
        let second = Second {
            time_s,
            done_s: node.armed_ticks as f64 * self.period_s,
            of_s: self.ticks as f64 * self.period_s,
            state: state(node, judging),
            partner: self.partner.clone(),
            round_trip_us: link.clock().round_trip_us(),
            rms_true_discrepancy_mm: mm(sum.rms_m()),
            largest_true_discrepancy_mm: mm(sum.largest_m()),
            true_discrepancy_error_mm: mm(sum.error_m()),
            clock_error_us: relation.map(|relation| 1e6 * relation.error_s(time_s)),
            live_share: link.is_up().then_some(live_share),
            stable,
            path: report.as_ref().map(PathSecond::of),
            fault: node.fault(),
        };
        self.newest = Some(second.clone());
        self.teller.second(second);
    }

    /// What there was to see; the recording is closed.
    pub(crate) fn end(mut self, now_s: f64) -> LiveSummary {
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
        (self.teller.log, self.paths) = (None, None);
        let recorded = self.recorder.take().and_then(Arc::into_inner).map(Recorder::finish);
        if let Some(ended) = &recorded {
            self.teller.words(ended.summary());
        }
        LiveSummary::of(&self.of_half, &self.of_all, clock, recorded.as_ref().map(Ended::summary))
    }
}
