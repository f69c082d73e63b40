//! One peer on a wire, whoever brings the time and the datagrams: the tick and exchange that fly, a simulated device in a
//! simulated hand, a sealed link.
//!
//! Each control period: [`Node::receive`] for every datagram that came, then [`Node::beat`]. Real time , a
//! flood  and restarts in virtual time  drive the same lines.
//!
//! **Who fades what.** The link knows *who* is there: it tells when a session begins and ends, and a peer that is told of an
//! end lets go at once. The peer's own ladder (`haptic_core::law::ladder`) knows *how much* comes: it fades packets
//! through silence and steps up again from no force. The link's level ([`Link::engagement`]) is the same ladder in time, for
//! a caller that has none of its own; here it only goes into the report, for two ladders in a row would fade twice.
//!
//! A node calls until flow is heard, then arms, disengaged, and runs the scene's user from there. Peers compute in f32, as
//! the board does.

use haptic_core::peer::{Actuators, Observed};
use haptic_core::safety::{Command, Mode};
use haptic_protocol::ends::Ends;
use haptic_protocol::key::Key;
use haptic_protocol::link::{Config, Error, Link, Notice, Stage};
use haptic_protocol::peer::{Inbox, flow_of, packet_of, parameters_of};
use haptic_protocol::wire::{Flow, MAX_DATAGRAM, Message, PeerId, Telemetry};

use crate::peers::DynPeer;
use crate::plant::Plant;
use crate::scene::Scene;

/// One peer, its device and its link.
#[derive(Debug)]
pub struct Node {
    peer: Box<dyn DynPeer<f32>>,
    plant: Plant,
    link: Link,
    inbox: Inbox,
    period_s: f64,
    /// Control periods since the start.
    ticks: u32,
    armed_ticks: u64,
    /// Control periods until the other one is told how this one is doing.
    until_telemetry: u32,
    /// What the other one last said about itself.
    heard: Option<Telemetry>,
    notices: Vec<(u64, Notice)>,
}

/// Time from telemetry to telemetry, s.
pub const TELEMETRY_S: f64 = 0.5;

/// The sealed line from one end of a scene to the other, calling.
pub fn open_link(scene: &Scene, ends: Ends, key: Key, entropy: [u8; Key::LEN]) -> Result<Link, String> {
    let settings = &scene.peers()[usize::from(ends.local == PeerId(2))];
    let timing = &settings.timing;
    Link::new(Config {
        key,
        ends,
        packet_period_us: (timing.packet_period_ns() / 1_000) as u32,
        parameters: parameters_of(settings),
        entropy,
    })
    .map_err(|error| error.to_string())
}

impl Node {
    /// Peer `number` (1 or 2) of a scene, disarmed and calling. `entropy` must never be the same at two starts.
    pub fn new(scene: &Scene, number: u8, key: Key, entropy: [u8; Key::LEN]) -> Result<Self, String> {
        Self::with_device(scene, number, key, entropy, Plant::new(scene, usize::from(number == 2)))
    }

    /// The same with a device that is there already: what a reset leaves of a peer.
    pub fn with_device(
        scene: &Scene,
        number: u8,
        key: Key,
        entropy: [u8; Key::LEN],
        plant: Plant,
    ) -> Result<Self, String> {
        let peer = scene.peer_from(usize::from(number == 2), plant.motions()).map_err(|refused| refused.to_string())?;
        let ends = Ends { local: PeerId(number), remote: PeerId(3 - number) };
        let link = open_link(scene, ends, key, entropy)?;
        Ok(Self {
            peer,
            plant,
            link,
            inbox: Inbox::new(scene.world.network.playout_packets, scene.peer.timing.ticks_per_packet),
            period_s: scene.peer.timing.control_period_s,
            ticks: 0,
            armed_ticks: 0,
            until_telemetry: 0,
            heard: None,
            notices: Vec::new(),
        })
    }

    /// Takes a datagram, which is opened in place; gives the flow, if it was that and the newest.
    pub fn receive(&mut self, now_us: u64, datagram: &mut [u8]) -> Result<Option<Flow>, Error> {
        let taken = self.link.receive(now_us, datagram);
        // Before the flow is kept: it may be the first of another life of the other peer.
        self.heed(now_us);
        let flow = match taken? {
            Some(Message::Flow(flow)) => flow,
            Some(Message::Telemetry(telemetry)) => {
                self.heard = Some(telemetry);
                return Ok(None);
            }
            _ => return Ok(None),
        };
        self.inbox.put(self.ticks, flow);
        Ok(Some(flow))
    }

    /// What the link has noticed.
    fn heed(&mut self, now_us: u64) {
        while let Some(notice) = self.link.take_notice() {
            if notice == Notice::Disengaged {
                self.peer.part();
                self.inbox.clear();
            }
            self.notices.push((now_us, notice));
        }
    }

    /// One control period: exchanges if that is due, says what is to be said, ticks, moves the device.
    pub fn beat(&mut self, now_us: u64, mut send: impl FnMut(&[u8])) -> Actuators<f32> {
        let mut out = [0; MAX_DATAGRAM];
        while let Some(len) = self.link.poll(now_us, &mut out) {
            send(&out[..len]);
        }
        self.heed(now_us);
        let due = self.peer.packet_due();
        if due {
            self.inbox.play(self.ticks);
        }
        if self.peer.mode() == Mode::Disarmed && self.inbox.newest().is_some() {
            self.peer.command(Command::Arm);
            self.peer.part();
        }
        if due {
            let (flow, anew) = self.inbox.take();
            if anew {
                self.peer.part();
            }
            let packet = self.peer.exchange(flow.as_ref().map(packet_of));
            let flow = flow_of(packet, self.peer.mode() == Mode::Armed, self.ticks);
            if let Some(len) = self.link.send(now_us, flow, &mut out) {
                send(&out[..len]);
            }
        }
        if self.until_telemetry == 0 {
            let telemetry = self.telemetry(now_us);
            // Without a session it is made up for as soon as there is one.
            if let Some(len) = self.link.send(now_us, telemetry, &mut out) {
                send(&out[..len]);
                self.until_telemetry = (TELEMETRY_S / self.period_s) as u32;
            }
        } else {
            self.until_telemetry -= 1;
        }
        self.ticks = self.ticks.wrapping_add(1);
        let actuators = self.peer.tick(&self.plant.sensors());
        // A hand that waits for the other one holds still.
        if self.peer.mode() != Mode::Disarmed {
            self.plant.step(self.armed_ticks as f64 * self.period_s, &actuators);
            self.armed_ticks += 1;
        }
        actuators
    }

    /// Tells the other one that this one ends.
    pub fn goodbye(&mut self, now_us: u64, mut send: impl FnMut(&[u8])) {
        let mut out = [0; MAX_DATAGRAM];
        if let Some(len) = self.link.goodbye(now_us, &mut out) {
            send(&out[..len]);
        }
    }

    /// How this one is doing, for the other end's people and logs.
    fn telemetry(&self, now_us: u64) -> Telemetry {
        let (seen, ledger) = (self.peer.observed(), self.peer.ledger());
        let (mode, fault) = match self.peer.mode() {
            Mode::Armed => (1, 0),
            Mode::Faulted(fault) => (2, fault.number()),
            _ => (0, 0),
        };
        let mut telemetry = Telemetry {
            mode,
            fault,
            tick: self.ticks,
            device_position: seen.device.position,
            object_position: seen.object.position,
            desired_position: seen.desired.position,
            contact_force: seen.contact_force,
            coordination_force: seen.coordination_force,
            energy_received: ledger.received_j().into(),
            energy_sent: ledger.sent_j().into(),
            ..Telemetry::default()
        };
        self.link.describe(now_us, &mut telemetry);
        telemetry
    }

    /// What the other one last said about itself, every half second.
    pub fn heard(&self) -> Option<&Telemetry> {
        self.heard.as_ref()
    }

    /// What a reset leaves: the device, in a hand that holds it still.
    pub fn device(&self) -> Plant {
        let mut plant = self.plant.clone();
        plant.rest();
        plant
    }

    /// Control periods since it was armed.
    pub fn armed_ticks(&self) -> u64 {
        self.armed_ticks
    }

    /// What the last tick saw and did.
    pub fn observed(&self) -> &Observed<f32> {
        self.peer.observed()
    }

    /// Whether forces reach the motors, and what stopped them.
    pub fn mode(&self) -> Mode {
        self.peer.mode()
    }

    /// Whether the coordination acts.
    pub fn is_engaged(&self) -> bool {
        self.peer.is_engaged()
    }

    /// The link.
    pub fn link(&self) -> &Link {
        &self.link
    }

    /// What the link has reported so far, in order, with the time of each in µs.
    pub fn notices(&self) -> &[(u64, Notice)] {
        &self.notices
    }

    /// How the node stands with the other one: what a datagram that is not the other one's must never change.
    pub fn standing(&self) -> (Stage, u32, u32, usize, Option<u32>, bool) {
        let link = &self.link;
        let tick = self.inbox.newest().map(|flow| flow.tick);
        let level = link.engagement().to_bits();
        (link.stage(), level, link.counts().taken, link.events_under_way(), tick, self.is_engaged())
    }

    /// All that a datagram could change, as text: link, newest flow and the peer, but for the count of refused datagrams.
    pub fn fingerprint(&self) -> String {
        let link = format!("{:?}", self.link);
        // The last field of all.
        let link = link.rfind("refused: ").map_or(link.as_str(), |end| &link[..end]);
        format!("{link} {:?} {:?} {:?}", self.inbox, self.heard, self.peer)
    }
}
