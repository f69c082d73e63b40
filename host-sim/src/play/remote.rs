//! One peer of two that are on two machines: its hand is the page's, or at a device of its own, its partner a process elsewhere, over the
//! sealed link.
//!
//! The other end is another `play`, a `peer` or a board's partner: whoever holds the key and has the same scene. Of the other
//! peer this one knows what its telemetry says, a few times a second. So **how far the copies are truly apart** is known when
//! telemetry comes: what it says of the other copy, less where this one was half a round trip before. In between the other copy is
//! drawn as far from this one as it was then; that is wrong by what the distance has changed since. Telemetry speaks of the first
//! shared axis; along the others the other copy is where this peer believes it to be, and so not in the sample.

use std::array::from_fn;
use std::collections::VecDeque;
use std::fmt;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};

use cohold_core::num::Motion;
use cohold_core::safety::{Command as Order, Mode};
use cohold_live::addresses::any_towards;
use cohold_live::batch::{MOST, OutgoingBatch, ReceivedBatch};
use cohold_live::devices::{DeviceOptions, Kind};
use cohold_live::endpoint::Endpoint;
use cohold_live::key_file::entropy;
use cohold_live::line_words::line_words;
use cohold_live::node::Node;
use cohold_live::path_watch::PathWatch;
use cohold_live::recording::recorder::Recorder;
use cohold_live::recording::ticks;
use cohold_live::road::Roads;
use cohold_live::tell::{Manner, PathSecond, Teller};
use cohold_live::verdict::{Judge, Judging};
use cohold_live::watch::{TELLING_S, Watch};
use cohold_protocol::key::Key;
use cohold_protocol::path::Path;
use cohold_protocol::wire::Telemetry;
use cohold_sim::device::Device;
use cohold_sim::peers::Builds;
use cohold_sim::scene::Scene;
use serde_json::json;

use super::environment::{ARMED, Command, Environment, FAULT, LineReport, OFF, Sample, Standing, WAITS, number_of};
use super::pair_columns::sample;
use super::session::{PERIOD_S, Side, first, on_device};
use cohold_cli::Failure;
use cohold_live::hand::Hand;

/// How much of a tick goes to what has come, so that no flood of datagrams holds it up.
const LISTENS: Duration = Duration::from_micros(300);
/// Windows are told of the path every so many ticks, and when it changes.
const NEWS: u64 = 1000;
/// How long one's own positions are kept, ticks: longer than telemetry is on its way.
const KEPT: usize = 4000;

/// This end of a line to another machine.
pub(crate) struct End {
    key: Key,
    /// Number of this peer, 1 or 2.
    pub(crate) number: u8,
    endpoint: Endpoint,
    /// Where the other listens; none, and it calls here.
    join: Option<SocketAddr>,
    device: DeviceOptions,
    /// Who says whether it may arm over the line that it measures; nobody, and it does.
    judge: Option<Judge>,
    /// Six digits that both ends of a link show.
    code: Option<String>,
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.join {
            Some(place) if self.meets() => write!(f, "peer {}, met at {place}", 3 - self.number),
            Some(join) => write!(f, "peer {} at {join}", 3 - self.number),
            None => write!(f, "peer {}, which joins at {}", 3 - self.number, self.endpoint.address),
        }
    }
}

impl End {
    /// When its clock began.
    pub(super) fn start(&self) -> Instant {
        self.endpoint.start()
    }

    fn new(key: Key, number: u8, endpoint: Endpoint, join: Option<SocketAddr>) -> Self {
        Self { key, number, endpoint, join, device: DeviceOptions::default(), judge: None, code: None }
    }

    /// Whether it meets the other one at a place.
    pub(super) fn meets(&self) -> bool {
        self.endpoint.road().is_some()
    }

    /// The end that the other one joins.
    pub(crate) fn listening(at: SocketAddr, key: Key, number: u8) -> Result<Self, Failure> {
        Ok(Self::new(key, number, Endpoint::polled(at)?, None))
    }

    /// The end that joins the other one.
    pub(crate) fn joining(to: SocketAddr, key: Key, number: u8) -> Result<Self, Failure> {
        let endpoint = Endpoint::polled(any_towards(to))?;
        endpoint.reaches(to)?;
        Ok(Self::new(key, number, endpoint, Some(to)))
    }

    /// The end that meets the other one at a place.
    pub(crate) fn meeting(meeting: &dyn Roads, key: Key, number: u8, code: Option<String>) -> Result<Self, Failure> {
        let endpoint = meeting.open(None, key.clone(), number - 1)?;
        Ok(Self { code, ..Self::new(key, number, endpoint, Some(meeting.place())) })
    }

    /// This end, with the hand at this device.
    pub(crate) fn with_device(self, device: DeviceOptions) -> Self {
        Self { device, ..self }
    }

    /// This end, which arms only where the judge lets it, as a `peer` does.
    pub(crate) fn with_judge(self, judge: Judge) -> Self {
        Self { judge: Some(judge), ..self }
    }

    /// Whether its hand is the page's.
    pub(crate) fn has_the_pages_hand(&self) -> bool {
        matches!(self.device.kind, Kind::Simulated)
    }
}

/// What the other one has said of itself.
#[derive(Clone, Copy, Debug)]
struct PartnerState {
    telemetry: Telemetry,
    /// Its copy less this one's at that time, m.
    offset_m: f64,
}

/// One peer that shares the object along `SHARED` axes of its device of `N`, and its line.
pub(super) struct Remote<const SHARED: usize, const N: usize> {
    scene: Scene,
    node: Node<SHARED, N, dyn Device<f32, N>>,
    /// 0 or 1.
    own: usize,
    endpoint: Endpoint,
    join: Option<SocketAddr>,
    path: Path<SocketAddr>,
    came: ReceivedBatch,
    going: OutgoingBatch,
    hand: Hand<SHARED>,
    pull_n: [f64; SHARED],
    side: Side<SHARED>,
    heard: u64,
    partner_state: Option<PartnerState>,
    /// Where this copy was in the last ticks, newest first, m.
    was: VecDeque<f64>,
    tick: u64,
    restarts: u32,
    cut: bool,
    /// Records it as a peer without a page is recorded.
    watch: Option<Watch>,
    /// Says what is not seen in a sample.
    teller: Teller,
    /// Its paths, where the other one is met somewhere.
    paths: Option<PathWatch>,
    /// Whether it may arm.
    judging: Option<Judging>,
    /// Six digits that both ends of a link show.
    code: Option<String>,
    /// A person has stopped it.
    stopped: bool,
    /// What windows are to be told of the line.
    news: Option<String>,
}

impl<const SHARED: usize, const N: usize> Remote<SHARED, N>
where
    f32: Builds<SHARED, N>,
{
    /// Calls, and arms when the other one is there.
    pub(super) fn new(scene: Scene, end: End) -> Result<Self, Failure> {
        let End { key, number, endpoint, join, device, judge, code } = end;
        let judging = judge.map(|judge| Judging::start(&judge, PERIOD_S)).transpose()?;
        // A device that is really there is read at every tick from here on, so it is the last of what may take time.
        let (device, seen) = device.open(&scene, number)?;
        let judging = judging.map(|judging| judging.of_device(seen));
        Ok(Self {
            paths: endpoint.road().map(PathWatch::new),
            teller: Teller::new(Manner::Words),
            judging,
            code,
            stopped: false,
            node: Node::with_device(&scene, number, key, entropy()?, device)?.telling_every(TELLING_S),
            own: usize::from(number) - 1,
            endpoint,
            join,
            path: Path::default(),
            came: ReceivedBatch::default(),
            going: OutgoingBatch::default(),
            hand: Hand::default(),
            pull_n: [0.0; SHARED],
            side: Side::new(&scene),
            heard: 0,
            partner_state: None,
            was: VecDeque::with_capacity(KEPT),
            tick: 0,
            restarts: 0,
            cut: false,
            watch: None,
            news: None,
            scene,
        })
    }

    /// Takes what has come.
    fn listen(&mut self) -> Result<(), Failure> {
        let until = Instant::now() + LISTENS;
        let Self { node, endpoint, join, path, came, going, cut, heard, watch, judging, .. } = self;
        let mut said = None;
        while Instant::now() < until && endpoint.take(came)? {
            let waited: [Duration; MOST] = from_fn(|at| came.waited.get(at).copied().unwrap_or_default());
            for ((from, datagram), waited) in came.each().zip(waited) {
                let now_ns = endpoint.now_ns();
                let now_us = now_ns / 1_000;
                if *cut {
                    continue;
                }
                node.line.link.waited(waited.as_micros() as u64);
                let taken = node.receive(now_us, datagram);
                path.heard(now_us, from, datagram, taken.is_ok(), &node.line.link);
                // What is refused is counted by the link.
                let Ok(flow) = taken else { continue };
                *heard += u64::from(flow.is_some());
                if let Some(judging) = judging {
                    judging.see(node.line.link.clock().newest());
                }
                if let Some(watch) = watch {
                    watch.heard(now_ns, &node.line, flow.is_some());
                }
                if let Some(telemetry) = node.line.heard.take() {
                    if let Some(watch) = watch {
                        watch.said(&telemetry, node.line.link.sealed_us(), node.armed_ticks);
                    }
                    said = Some(telemetry);
                }
                node.line.link.say_due(now_us, |out| {
                    if let Some(to) = join.or_else(|| path.of(out, Some(from))) {
                        endpoint.say(going, to, out);
                    }
                });
            }
        }
        if let Some(telemetry) = said {
            let round_trip_us = self.node.line.link.clock().round_trip_us().unwrap_or_default();
            let ago = (0.5e-6 * f64::from(round_trip_us) / PERIOD_S).round() as usize;
            let here = self.was.get(ago).or(self.was.back()).copied().unwrap_or_default();
            self.partner_state =
                Some(PartnerState { telemetry, offset_m: f64::from(telemetry.object_position) - here });
        }
        Ok(())
    }

    fn device(&self) -> [Motion<f64>; SHARED] {
        first(self.node.motions())
    }

    /// What windows are told of the line before anybody pushes; none while nothing is known.
    fn line_news(&self) -> Option<String> {
        let path = self.paths.as_ref().map(|paths| PathSecond::of(&paths.report()));
        let (round_trip_us, judging) = (self.node.line.link.clock().round_trip_us(), self.judging.as_ref());
        let said = line_words(&self.scene, round_trip_us, path, judging, self.code.as_deref())?;
        Some(json!({ "path": said }).to_string())
    }

    fn sample(&mut self) -> Sample {
        let booked = self.side.see(&*self.node.peer, self.heard);
        let link = &self.node.line.link;
        let one_way_s = link.clock().round_trip_us().map_or(f32::NAN, |us| 0.5e-6 * us as f32);
        let partner_state = self.partner_state.filter(|_| link.is_up());
        let up = f32::from(u8::from(link.is_up()));
        let (seen, device, holds) = (self.node.peer.observed(), self.device(), self.hand.holds());
        let both = |own: f32, other: f32| if self.own == 0 { [own, other] } else { [other, own] };
        let axis = |axis: usize| {
            // What the other one says of itself, it says of the first axis.
            let other = partner_state.filter(|_| axis == 0);
            let (seen, object) = (seen[axis], f64::from(seen[axis].object.position));
            let there = |of: fn(&Telemetry) -> f32| other.as_ref().map_or(f32::NAN, |other| of(&other.telemetry));
            let drawn = other.map_or(f32::NAN, |other| (object + other.offset_m) as f32);
            [
                both(holds.map_or(f32::NAN, |at| at[axis] as f32), f32::NAN),
                both(
                    device[axis].position as f32,
                    drawn + there(|other| other.device_position - other.object_position),
                ),
                both(object as f32, drawn),
                both(seen.desired.position, there(|other| other.desired_position)),
                both(seen.contact_force, there(|other| other.contact_force)),
                both(seen.coordination_force, there(|other| other.coordination_force)),
                both(self.pull_n[axis] as f32, f32::NAN),
                // What the scene's users do, its peers do not tell.
                [f32::NAN; 2],
            ]
        };
        let ([kept_1, kept_2], [live_1, live_2]) = (both(booked.kept_j as f32, f32::NAN), both(booked.live, up));
        let rest = [f32::NAN, kept_1, kept_2, one_way_s, one_way_s, live_1, live_2];
        sample(from_fn::<_, SHARED, _>(axis), rest, self.restarts)
    }
}

impl<const SHARED: usize, const N: usize> Environment for Remote<SHARED, N>
where
    f32: Builds<SHARED, N>,
{
    fn command(&mut self, command: Command) -> Result<(), Failure> {
        match command {
            Command::Stop => {
                self.stopped = true;
                self.node.halt(true);
            }
            Command::Start => {
                if matches!(self.node.peer.mode(), Mode::Faulted(_)) {
                    self.node.peer.command(Order::Clear);
                }
                self.stopped = false;
                self.node.halt(self.judging.as_ref().is_some_and(|judging| !judging.lets_arm()));
                self.hand = Hand::default();
                self.restarts += 1;
            }
            Command::Cut(cut) => self.cut = cut,
            // Nobody but a person plays this hand, and nobody here the other one.
            Command::Partner(_) | Command::Board(..) => {}
        }
        Ok(())
    }

    fn set(&mut self, scene: Scene) -> Result<(), Failure> {
        self.scene = scene;
        Ok(())
    }

    fn point(&mut self, hand: usize, at: Option<[f64; 3]>, restarts: u32) {
        if hand == self.own {
            let at = at.filter(|_| restarts == self.restarts).map(first);
            self.hand.point(self.tick, at, self.device().map(|axis| axis.position));
        }
    }

    fn step(&mut self) -> Result<Sample, Failure> {
        self.listen()?;
        self.pull_n = self.hand.pull(self.tick, self.device(), PERIOD_S);
        self.node.pull(on_device(self.pull_n, self.node.motions()));
        let Self { node, endpoint, join, path, going, cut, watch, teller, paths, judging, stopped, .. } = self;
        let now_ns = endpoint.now_ns();
        let words = judging.as_mut().and_then(|judging| judging.heed(now_ns / 1_000, node, *stopped));
        let judged = words.is_some();
        words.into_iter().for_each(|words| teller.words(words));
        node.tick(now_ns / 1_000, |bytes| {
            if let Some(to) = join.or_else(|| path.of(bytes, None)).filter(|_| !*cut) {
                endpoint.say(going, to, bytes);
            }
        });
        endpoint.flush(going);
        if let Some(watch) = watch {
            watch.ticked(now_ns, node, judging.as_ref());
        }
        let changed = paths.as_ref().is_some_and(|paths| paths.look(now_ns, teller));
        let due = self.tick.is_multiple_of(NEWS);
        if let Some(paths) = paths.as_ref().filter(|_| due) {
            paths.second(now_ns);
        }
        if due || changed || judged {
            self.news = self.line_news();
        }
        self.was.truncate(KEPT - 1);
        self.was.push_front(f64::from(self.node.observed().object.position));
        self.tick += 1;
        Ok(self.sample())
    }

    fn news(&mut self) -> Option<String> {
        self.news.take()
    }

    fn record(&mut self, recorder: Arc<Recorder>) {
        let channel = ticks::paths(self.scene.peer.axis.shared as usize);
        self.paths = self.paths.take().map(|paths| paths.recording(Arc::clone(&recorder), channel));
        self.teller.log = Some(Arc::clone(&recorder));
        self.watch = Some(Watch::recording(recorder, &self.scene));
    }

    fn line(&self) -> Option<LineReport> {
        let judging = self.judging.as_ref();
        Some(LineReport {
            round_trip_us: self.node.line.link.clock().round_trip_us(),
            path: self.paths.as_ref().map(PathWatch::report),
            verdict: judging.and_then(|judging| judging.verdict.clone()),
            verdicts: judging.map(|judging| judging.said.clone()).unwrap_or_default(),
        })
    }

    fn standing(&self) -> Standing {
        let link = &self.node.line.link;
        let own = match (self.node.gone(), number_of(self.node.peer.mode())) {
            (Some(gone), _) => FAULT + gone.fault as u8,
            // A verdict that does not let it arm is waited out, too.
            (None, OFF) if !self.stopped => WAITS,
            (None, mode) => mode,
        };
        let other = match self.partner_state.filter(|_| link.is_up()).map(|partner_state| partner_state.telemetry) {
            None => WAITS,
            Some(Telemetry { mode: 1, .. }) => ARMED,
            Some(Telemetry { mode: 2, fault, .. }) => FAULT + fault,
            Some(_) => OFF,
        };
        let modes = if self.own == 0 { [own, other] } else { [other, own] };
        Standing { modes, cut: self.cut, partner: 0 }
    }
}

impl<const SHARED: usize, const N: usize> Drop for Remote<SHARED, N> {
    fn drop(&mut self) {
        let Self { node, endpoint, join, path, .. } = self;
        node.goodbye(endpoint.now_ns() / 1_000, |bytes| {
            if let Some(to) = join.or_else(|| path.of(bytes, None)) {
                endpoint.send(to, bytes);
            }
        });
    }
}

#[cfg(test)]
#[path = "../../tests/inside/remote.rs"]
mod tests;
