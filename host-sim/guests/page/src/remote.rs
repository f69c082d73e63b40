//! One peer of two that are on two machines: its hand is the page's, or at a device of its own, its partner a process elsewhere, over the
//! sealed link. It is a [`LivePeer`], which the page's control loop gives its turns and which the page steers.
//!
//! The other end is another `play`, a `peer` or a board's partner: whoever holds the key and has the same scene. Of the other
//! peer this one knows what its telemetry says, a few times a second. So **how far the copies are truly apart** is known when
//! telemetry comes. In between the other copy is drawn as far from this one as it was then; that is wrong by what the distance has
//! changed since. Telemetry speaks of the first shared axis; along the others the other copy is where this peer believes it to be, and so
//! not in the sample.

use std::array::from_fn;
use std::fmt;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};

use cohold_core::num::Motion;
use cohold_core::safety::Mode;
use cohold_live::addresses::any_towards;
use cohold_live::batch::{OutgoingBatch, ReceivedBatch};
use cohold_live::devices::{DeviceOptions, Kind};
use cohold_live::endpoint::{Endpoint, Live as _, Span};
use cohold_live::peer::{LivePeer, OneEnd};
use cohold_live::recording::recorder::Recorder;
use cohold_live::road::Roads;
use cohold_live::steering::Steering;
use cohold_live::tell::{Manner, PathSecond};
use cohold_live::verdict::Judge;
use cohold_live::watch::LiveOptions;
use cohold_protocol::key::Key;
use cohold_protocol::wire::Telemetry;
use cohold_sim::peers::Builds;
use cohold_sim::scene::Scene;
use serde_json::json;

use super::environment::{ARMED, Command, Environment, FAULT, LineReport, OFF, Sample, Standing, WAITS, number_of};
use super::line_words::line_words;
use super::pair_columns::sample;
use super::session::{first, on_device};
use cohold_cli::Failure;

/// How much of a tick goes to what has come, so that no flood of datagrams holds it up.
const LISTENS: Duration = Duration::from_micros(300);
/// Windows are told of the path every so many ticks, and when it changes.
const NEWS: u64 = 1000;
/// A page waits and goes on as long as it is open.
const UNTIL_CLOSED: Span = Span { duration_s: f64::INFINITY, patience_s: f64::INFINITY };

/// This end of a line to another machine.
pub(crate) struct End {
    pub(crate) key: Key,
    /// Number of this peer, 1 or 2.
    pub(crate) number: u8,
    pub(crate) endpoint: Endpoint,
    /// Where the other listens; none, and it calls here.
    pub(crate) join: Option<SocketAddr>,
    pub(crate) device: DeviceOptions,
    /// Who says whether it may arm over the line that it measures; nobody, and it does.
    pub(crate) judge: Option<Judge>,
    /// Six digits that both ends of a link show.
    pub(crate) code: Option<String>,
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

    /// Whether its hand is the page's.
    pub(crate) fn has_the_pages_hand(&self) -> bool {
        matches!(self.device.kind, Kind::Simulated)
    }
}

/// One peer that shares the object along `SHARED` axes of its device of `N`, and its line.
pub(super) struct Remote<const SHARED: usize, const N: usize> {
    scene: Scene,
    peer: LivePeer<SHARED, N>,
    /// What the page wants of it.
    steering: Arc<Steering>,
    /// 0 or 1.
    own: usize,
    endpoint: Endpoint,
    came: ReceivedBatch,
    going: OutgoingBatch,
    tick: u64,
    restarts: u32,
    /// Six digits that both ends of a link show.
    code: Option<String>,
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
        let steering = Arc::new(Steering::new(true));
        let wanted = LiveOptions {
            manner: Manner::Events,
            judge,
            device,
            steering: Some(Arc::clone(&steering)),
            ..LiveOptions::default()
        };
        let peer = LivePeer::open(&scene, OneEnd { number, key, other: join }, &endpoint, UNTIL_CLOSED, &wanted)?;
        Ok(Self {
            scene,
            peer,
            steering,
            own: usize::from(number) - 1,
            endpoint,
            came: ReceivedBatch::default(),
            going: OutgoingBatch::default(),
            tick: 0,
            restarts: 0,
            code,
            news: None,
        })
    }

    fn device(&self) -> [Motion<f64>; SHARED] {
        first(self.peer.node.motions())
    }

    /// What windows are told of the line before anybody pushes; none while nothing is known.
    fn line_news(&self) -> Option<String> {
        let path = self.peer.watch.paths().as_ref().map(PathSecond::of);
        let (round_trip_us, judging) = (self.peer.node.line.link.clock().round_trip_us(), self.peer.judging.as_ref());
        let said = line_words(&self.scene, round_trip_us, path, judging, self.code.as_deref())?;
        Some(json!({ "path": said }).to_string())
    }

    /// What the other one has said of itself, while it is there.
    fn partner(&self) -> Option<&Telemetry> {
        let line = &self.peer.node.line;
        line.heard.as_ref().filter(|_| line.link.is_up())
    }

    fn sample(&self) -> Sample {
        let (node, (holds, pull_n)) = (&self.peer.node, self.peer.hand());
        let link = &node.line.link;
        let one_way_s = link.clock().round_trip_us().map_or(f32::NAN, |us| 0.5e-6 * us as f32);
        let [up, live] = [link.is_up(), self.peer.watch.live].map(|is| f32::from(u8::from(is)));
        let (seen, device) = (node.peer.observed(), self.device());
        let both = |own: f32, other: f32| if self.own == 0 { [own, other] } else { [other, own] };
        let axis = |axis: usize| {
            // What the other one says of itself, it says of the first axis.
            let other = self.partner().filter(|_| axis == 0);
            let (seen, object) = (seen[axis], f64::from(seen[axis].object.position));
            let there = |of: fn(&Telemetry) -> f32| other.map_or(f32::NAN, of);
            let drawn = other.map_or(f32::NAN, |_| (object + self.peer.offset_m) as f32);
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
                both(pull_n[axis] as f32, f32::NAN),
                // What the scene's users do, its peers do not tell.
                [f32::NAN; 2],
            ]
        };
        let ([kept_1, kept_2], [live_1, live_2]) = (both(self.peer.kept_j() as f32, f32::NAN), both(live, up));
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
            Command::Stop => self.steering.want(|wanted| wanted.armed = false),
            Command::Start => {
                let faulted = matches!(self.peer.node.peer.mode(), Mode::Faulted(_));
                self.steering.want(|wanted| {
                    (wanted.armed, wanted.hand_m) = (true, None);
                    wanted.clears += u64::from(faulted);
                });
                self.restarts += 1;
            }
            Command::Cut(cut) => self.peer.other.cut = cut,
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
            self.steering.want(|wanted| {
                wanted.hand_m = at.filter(|_| restarts == self.restarts);
                wanted.moves += 1;
            });
        }
    }

    fn step(&mut self) -> Result<Sample, Failure> {
        let ends: [f64; N] = on_device([0.0; SHARED], self.peer.node.motions());
        self.steering.want(|wanted| wanted.pull_n = first(ends));
        self.endpoint.turn((&mut self.came, &mut self.going), Instant::now() + LISTENS, &mut self.peer)?;
        let due = self.tick.is_multiple_of(NEWS);
        if std::mem::take(&mut self.peer.has_news) || due {
            self.news = self.line_news();
        }
        self.tick += 1;
        Ok(self.sample())
    }

    fn news(&mut self) -> Option<String> {
        self.news.take()
    }

    fn record(&mut self, recorder: Arc<Recorder>) {
        self.peer.watch.record_into(recorder, &self.scene);
    }

    fn line(&self) -> Option<LineReport> {
        let judging = self.peer.judging.as_ref();
        Some(LineReport {
            round_trip_us: self.peer.node.line.link.clock().round_trip_us(),
            path: self.peer.watch.paths(),
            verdict: judging.and_then(|judging| judging.verdict.clone()),
            verdicts: judging.map(|judging| judging.said.clone()).unwrap_or_default(),
        })
    }

    fn standing(&self) -> Standing {
        let node = &self.peer.node;
        let own = match (node.gone(), number_of(node.peer.mode())) {
            (Some(gone), _) => FAULT + gone.fault as u8,
            // A verdict that does not let it arm is waited out, too.
            (None, OFF) if self.steering.wanted().armed => WAITS,
            (None, mode) => mode,
        };
        let other = match self.partner() {
            None => WAITS,
            Some(Telemetry { mode: 1, .. }) => ARMED,
            Some(Telemetry { mode: 2, fault, .. }) => FAULT + fault,
            Some(_) => OFF,
        };
        let modes = if self.own == 0 { [own, other] } else { [other, own] };
        Standing { modes, cut: self.peer.other.cut, partner: 0 }
    }
}

impl<const SHARED: usize, const N: usize> Drop for Remote<SHARED, N> {
    fn drop(&mut self) {
        let Self { peer, endpoint, .. } = self;
        peer.goodbye(endpoint.now_ns(), &mut |to, bytes| _ = endpoint.send(to, bytes));
    }
}

#[cfg(test)]
#[path = "../tests/inside/remote.rs"]
mod tests;
