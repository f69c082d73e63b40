//! One peer of two that are on two machines: its hand is the page's, its partner a process elsewhere, over the sealed link.
//!
//! The other end is another `play`, a `peer` or a board's partner: whoever holds the key and has the same scene. Of the other
//! peer this one knows what its telemetry says, a few times a second. So **how far the copies are truly apart** is known when
//! telemetry comes: what it says of the other copy, less where this one was half a round trip before. In between the other copy is
//! drawn as far from this one as it was then; that is wrong by what the distance has changed since.

use std::collections::VecDeque;
use std::fmt;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};
use std::time::{Duration, Instant};

use haptic_core::safety::{Command as Order, Mode};
use haptic_live::batch::{OutgoingBatch, ReceivedBatch};
use haptic_live::endpoint::Endpoint;
use haptic_protocol::path::Path;
use haptic_protocol::{key::Key, wire::Telemetry};
use haptic_sim::node::{Node, Transmit as _};
use haptic_sim::{key_file::entropy, scene::Scene};

use super::environment::{ARMED, Command, Environment, FAULT, MOST, OFF, Sample, Standing, WAITS, number_of};
use super::hand::Hand;
use super::session::{PERIOD_S, Side, end_of_travel};
use crate::Error;

/// How much of a tick goes to what has come, so that no flood of datagrams holds it up.
const LISTENS: Duration = Duration::from_micros(300);
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
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.join {
            Some(join) => write!(f, "peer {} at {join}", 3 - self.number),
            None => write!(f, "peer {}, which joins at {}", 3 - self.number, self.endpoint.address),
        }
    }
}

impl End {
    /// The end that the other one joins.
    pub(crate) fn listening(at: SocketAddr, key: Key, number: u8) -> Result<Self, Error> {
        Ok(Self { key, number, endpoint: Endpoint::polled(at)?, join: None })
    }

    /// The end that joins the other one.
    pub(crate) fn joining(to: SocketAddr, key: Key, number: u8) -> Result<Self, Error> {
        let any = if to.is_ipv4() { Ipv4Addr::UNSPECIFIED.into() } else { Ipv6Addr::UNSPECIFIED.into() };
        let endpoint = Endpoint::polled(SocketAddr::new(any, 0))?;
        endpoint.reaches(to)?;
        Ok(Self { key, number, endpoint, join: Some(to) })
    }
}

/// What the other one has said of itself.
#[derive(Clone, Copy, Debug)]
struct PartnerState {
    telemetry: Telemetry,
    /// Its copy less this one's at that time, m.
    offset_m: f64,
}

/// One peer and its line.
pub(super) struct Remote {
    scene: Scene,
    node: Node,
    /// 0 or 1.
    own: usize,
    endpoint: Endpoint,
    join: Option<SocketAddr>,
    path: Path<SocketAddr>,
    came: ReceivedBatch,
    going: OutgoingBatch,
    hand: Hand,
    pull_n: f64,
    side: Side,
    heard: u64,
    partner_state: Option<PartnerState>,
    /// Where this copy was in the last ticks, newest first, m.
    was: VecDeque<f64>,
    tick: u64,
    restarts: u32,
    cut: bool,
}

impl Remote {
    /// Calls, and arms when the other one is there.
    pub(super) fn new(scene: Scene, end: End) -> Result<Self, Error> {
        let End { key, number, endpoint, join } = end;
        Ok(Self {
            node: Node::new(&scene, number, key, entropy()?)?,
            own: usize::from(number) - 1,
            endpoint,
            join,
            path: Path::default(),
            came: ReceivedBatch::default(),
            going: OutgoingBatch::default(),
            hand: Hand::default(),
            pull_n: 0.0,
            side: Side::new(&scene),
            heard: 0,
            partner_state: None,
            was: VecDeque::with_capacity(KEPT),
            tick: 0,
            restarts: 0,
            cut: false,
            scene,
        })
    }

    /// Takes what has come.
    fn listen(&mut self) -> Result<(), Error> {
        let until = Instant::now() + LISTENS;
        let Self { node, endpoint, join, path, came, going, cut, heard, .. } = self;
        while Instant::now() < until && endpoint.take(came)? {
            for (from, datagram) in came.each() {
                let now_us = endpoint.now_ns() / 1_000;
                if *cut {
                    continue;
                }
                let taken = node.receive(now_us, datagram);
                let link = &mut node.line.link;
                path.heard(now_us, from, datagram, taken.is_ok(), link);
                // What is refused is counted by the link.
                let Ok(flow) = taken else { continue };
                *heard += u64::from(flow.is_some());
                link.say_due(now_us, |out| {
                    if let Some(to) = join.or_else(|| path.of(out, Some(from))) {
                        endpoint.say(going, to, out);
                    }
                });
            }
        }
        if let Some(telemetry) = self.node.line.heard.take() {
            let round_trip_us = self.node.line.link.clock().round_trip_us().unwrap_or_default();
            let ago = (0.5e-6 * f64::from(round_trip_us) / PERIOD_S).round() as usize;
            let here = self.was.get(ago).or(self.was.back()).copied().unwrap_or_default();
            self.partner_state =
                Some(PartnerState { telemetry, offset_m: f64::from(telemetry.object_position) - here });
        }
        Ok(())
    }

    fn sample(&mut self) -> Sample {
        let seen = *self.node.observed();
        let booked = self.side.see(&*self.node.peer, self.heard);
        let link = &self.node.line.link;
        let one_way_s = link.clock().round_trip_us().map_or(f32::NAN, |us| 0.5e-6 * us as f32);
        let object = f64::from(seen.object.position);
        let partner_state = self.partner_state.filter(|_| link.is_up());
        let other = partner_state.map(|partner_state| partner_state.telemetry).unwrap_or_default();
        let there = |number: f32| if partner_state.is_some() { number } else { f32::NAN };
        let wanted = self.hand.holds().map_or(f32::NAN, |at| at as f32);
        let device = self.node.motion().position as f32;
        let drawn = partner_state.map_or(f32::NAN, |partner_state| (object + partner_state.offset_m) as f32);
        let both = |own: f32, other: f32| if self.own == 0 { [own, other] } else { [other, own] };
        let pairs = [
            both(wanted, f32::NAN),
            both(device, drawn + (other.device_position - other.object_position)),
            both(object as f32, drawn),
            both(seen.desired.position, there(other.desired_position)),
            both(seen.contact_force, there(other.contact_force)),
            both(seen.coordination_force, there(other.coordination_force)),
            both(self.pull_n as f32, f32::NAN),
        ];
        let rest = [
            [f32::NAN; 1].as_slice(),
            &both(booked.kept_j as f32, f32::NAN),
            &[one_way_s; 2],
            &both(booked.live, f32::from(u8::from(link.is_up()))),
            &[self.restarts as f32],
        ];
        let mut sample = [f32::NAN; MOST];
        let numbers = pairs.into_iter().flatten().chain(rest.into_iter().flatten().copied());
        sample.iter_mut().zip(numbers).for_each(|(to, number)| *to = number);
        sample
    }
}

impl Environment for Remote {
    fn command(&mut self, command: Command) -> Result<(), Error> {
        match command {
            Command::Stop => self.node.halt(true),
            Command::Start => {
                if matches!(self.node.peer.mode(), Mode::Faulted(_)) {
                    self.node.peer.command(Order::Clear);
                }
                self.node.halt(false);
                self.hand = Hand::default();
                self.restarts += 1;
            }
            Command::Cut(cut) => self.cut = cut,
            // Nobody but a person plays this hand, and nobody here the other one.
            Command::Partner(_) | Command::Board(..) => {}
        }
        Ok(())
    }

    fn set(&mut self, scene: Scene) -> Result<(), Error> {
        self.scene = scene;
        Ok(())
    }

    fn point(&mut self, hand: usize, at: Option<[f64; 2]>, restarts: u32) {
        if hand == self.own {
            let at = at.filter(|_| restarts == self.restarts).map(|[along, _]| along);
            self.hand.point(self.tick, at, self.node.motion().position);
        }
    }

    fn play(&mut self, hand: usize) {
        self.point(hand, None, self.restarts);
    }

    fn step(&mut self) -> Result<Sample, Error> {
        self.listen()?;
        let motion = self.node.motion();
        self.pull_n = self.hand.pull(self.tick, motion.position, motion.velocity, PERIOD_S);
        self.node.pull([self.pull_n - end_of_travel(motion), 0.0]);
        let Self { node, endpoint, join, path, going, cut, .. } = self;
        node.tick(endpoint.now_ns() / 1_000, |bytes| {
            if let Some(to) = join.or_else(|| path.of(bytes, None)).filter(|_| !*cut) {
                endpoint.say(going, to, bytes);
            }
        });
        endpoint.flush(going);
        self.was.truncate(KEPT - 1);
        self.was.push_front(f64::from(node.observed().object.position));
        self.tick += 1;
        Ok(self.sample())
    }

    fn standing(&self) -> Standing {
        let link = &self.node.line.link;
        let own = match number_of(self.node.peer.mode()) {
            OFF if !self.node.is_halted() => WAITS,
            mode => mode,
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

impl Drop for Remote {
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
