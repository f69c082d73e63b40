//! One peer behind a sealed (encrypted) link: cohold-core's peer, its device and user, simulated or really there ([`Device`]), and the
//! link. The caller brings time and datagrams.
//!
//! Each control period: [`Node::receive`] for every datagram that came, then [`Node::tick`]. Real-time programs and
//! trials in virtual time (floods of packets, restarts) use the same code.
//!
//! **Who fades what.** The link knows *who* is there: it reports when a session begins and ends, and a peer that is
//! notified of an end disengages at once. The peer's own degradation (`cohold_core::law::degradation`) knows *how much*
//! comes: it fades packets through silence and steps up again from no force.
//!
//! A node calls until it hears a flow message, then arms, disengaged. When both ends are live ([`crate::start`]) it runs the scene's user,
//! whose hand does nothing before that. Peers compute in f32, as the board does. Of an object that is shared along several axes one
//! datagram has the packets of all of them.
//!
//! A device that is [`Gone`] turns the motors off in the tick that notices, and they stay off ([`Node::gone`]).

use std::collections::VecDeque;

use cohold_core::device::AXES;
use cohold_core::law::ledger::Ledger;
use cohold_core::num::Motion;
use cohold_core::peer::{Actuators, Arrived, Observed};
use cohold_core::safety::{Command, Mode};
use cohold_protocol::end::End;
use cohold_protocol::link::{Error, Link, Notice};
use cohold_protocol::peer::{Inbox, flow_of, open, packets_of};
use cohold_protocol::wire::{Flows, Goodbye, PeerId, Telemetry};
use cohold_protocol::{ends::Ends, key::Key};
use cohold_sim::device::{Device, Gone};
use cohold_sim::peers::{Builds, DynPeer};
use cohold_sim::{plant::Plant, scene::Scene};

use crate::start::Start;

/// One peer that shares the object along `SHARED` axes of its device of `N`, that device and its link.
#[derive(Debug)]
pub struct Node<const SHARED: usize = 1, const N: usize = AXES, D: ?Sized = Plant<N>> {
    /// The peer; only the node gives it a tick.
    pub peer: Box<dyn DynPeer<f32, SHARED, N>>,
    device: Box<D>,
    /// Why the device is driven no more.
    gone: Option<Gone>,
    /// Its motors are off until somebody says otherwise.
    halted: bool,
    /// Its clutch is open.
    clutched: bool,
    /// Somebody holds it open, whatever the device's own button does.
    clutch_is_held: bool,
    /// Its end of the sealed line to the other node.
    pub line: Line<SHARED>,
    period_s: f64,
    /// Control periods since the start.
    ticks: u32,
    /// Its law loses what comes while it steps up from silence; a line with a time of its own loses nothing.
    fades: bool,
    /// It has begun to move since it was armed last.
    begun: bool,
    /// How long after both ends are live it begins, µs.
    after_us: u64,
    /// Control periods in which it moved.
    pub armed_ticks: u64,
    /// From telling the other one how this one is doing to the next time, s.
    telemetry_s: f64,
    /// Control periods until then.
    until_telemetry: u32,
}

/// Default time between two telemetry messages, s; [`Node::telling_every`] sets another.
pub const TELEMETRY_S: f64 = 0.5;

/// Most notices of a line that are kept; older ones are dropped.
pub const MOST_NOTICES: usize = 256;

/// One end of the sealed line between the two peers of a scene, and what has come over it.
#[derive(Debug)]
pub struct Line<const SHARED: usize = 1> {
    /// The sealed link to the other peer.
    pub link: Link,
    /// Received flow (the packets of the control loop) that waits for the next exchange.
    pub inbox: Inbox<SHARED>,
    /// Newest telemetry of the other peer, which it sends every [`TELEMETRY_S`] by default.
    pub heard: Option<Telemetry>,
    /// What the link has reported, in order, with the time of each in µs: the newest [`MOST_NOTICES`].
    pub notices: VecDeque<(u64, Notice)>,
    /// Number of notices so far, dropped ones included.
    pub noticed: u64,
    /// Number of starts of the other peer that were noticed: its first, and each restart.
    pub lives: u64,
    /// When both ends became live.
    pub start: Start,
}

impl<const SHARED: usize> Line<SHARED> {
    /// The end of peer `number` (1 or 2), calling. `entropy` must never be the same at two starts.
    ///
    /// # Errors
    /// Settings from which no link can be built.
    pub fn open(scene: &Scene, number: u8, key: Key, entropy: [u8; Key::LEN]) -> Result<Self, crate::Error> {
        let peers = scene.peers();
        let [settings, other] = [number == 2, number != 2].map(|second| &peers[usize::from(second)]);
        let ends = Ends { local: PeerId(number), remote: PeerId(3 - number) };
        let link = open(settings, key, ends, entropy).map_err(cohold_board_tools::Error::from)?;
        let bounds = scene.laws.bounds(other).beyond_a_junction();
        let inbox = Inbox::new(bounds, scene.world.network.playout_packets, settings.timing.ticks_per_packet);
        Ok(Self { link, inbox, heard: None, notices: VecDeque::new(), noticed: 0, lives: 0, start: Start::default() })
    }
}

impl<const SHARED: usize> End<SHARED> for Line<SHARED> {
    fn link(&mut self) -> &mut Link {
        &mut self.link
    }

    fn notice(&mut self, now_us: u64, notice: Notice) {
        if notice == Notice::Disengaged {
            self.inbox.clear();
            self.start.hear(now_us, false);
        }
        self.lives += u64::from(matches!(notice, Notice::NewPeer(_)));
        if self.notices.len() == MOST_NOTICES {
            self.notices.pop_front();
        }
        self.noticed += 1;
        self.notices.push_back((now_us, notice));
    }

    fn keep(&mut self, tick: u32, sealed_us: u64, flow: Flows<SHARED>) -> Result<(), Error> {
        self.inbox.put(tick, flow)?;
        self.start.hear(sealed_us, flow.engaged && !flow.fading);
        Ok(())
    }

    fn telemetry(&mut self, said: Telemetry) {
        self.heard = Some(said);
    }
}

impl<const SHARED: usize, const N: usize> Node<SHARED, N>
where
    f32: Builds<SHARED, N>,
{
    /// Peer `number` (1 or 2) of a scene that shares the object along `SHARED` axes, disarmed and calling. `entropy` must never be the
    /// same at two starts.
    ///
    /// # Errors
    /// A scene that cannot be built, another number of shared axes, or settings from which no link can be built.
    pub fn build(scene: &Scene, number: u8, key: Key, entropy: [u8; Key::LEN]) -> Result<Self, crate::Error> {
        Self::with_device(scene, number, key, entropy, Box::new(Plant::build(scene, usize::from(number == 2))))
    }
}

impl<const SHARED: usize, const N: usize, D: Device<f32, N> + ?Sized> Node<SHARED, N, D>
where
    f32: Builds<SHARED, N>,
{
    /// [`Node::build`], with the same errors, for a device that exists already: what a reset leaves of a peer, or one that is really
    /// there. The peer's home is where it is now.
    pub fn with_device(
        scene: &Scene,
        number: u8,
        key: Key,
        entropy: [u8; Key::LEN],
        device: Box<D>,
    ) -> Result<Self, crate::Error> {
        let peer = scene.laws.peer(&scene.peers()[usize::from(number == 2)], device.start());
        let peer = peer.map_err(cohold_sim::Error::from)?;
        let (line, period_s) = (Line::open(scene, number, key, entropy)?, scene.peer.timing.control_period_s);
        let telemetry_s = TELEMETRY_S;
        Ok(Self {
            peer,
            device,
            gone: None,
            halted: false,
            clutched: false,
            clutch_is_held: false,
            line,
            period_s,
            ticks: 0,
            fades: !scene.law().own_time,
            begun: false,
            after_us: 0,
            armed_ticks: 0,
            telemetry_s,
            until_telemetry: 0,
        })
    }
}

impl<const SHARED: usize, const N: usize, D: Device<f32, N> + ?Sized> Node<SHARED, N, D> {
    /// This node, which sends its telemetry every `telemetry_s` seconds.
    #[must_use]
    pub fn telling_every(self, telemetry_s: f64) -> Self {
        Self { telemetry_s, ..self }
    }

    /// This node, which begins to move `after_us` µs after both ends are live: [`crate::start::AFTER_US`] where both are to begin at once.
    #[must_use]
    pub fn beginning_after(self, after_us: u64) -> Self {
        Self { after_us, ..self }
    }

    /// Takes a datagram, which is opened in place; gives the flow, if it was that and the newest.
    ///
    /// # Errors
    /// The datagram was refused, and why.
    pub fn receive(&mut self, now_us: u64, datagram: &mut [u8]) -> Result<Option<Flows<SHARED>>, Error> {
        self.line.receive(now_us, self.ticks, datagram)
    }

    /// Advances by one control period: exchanges packets if due, sends what is due by `send`, ticks the peer and moves the device.
    pub fn tick(&mut self, now_us: u64, mut send: impl FnMut(&[u8])) -> Actuators<f32, N> {
        self.line.link.say_due(now_us, &mut send);
        self.line.heed(now_us);
        self.line.inbox.play(self.ticks);
        if let (None, Err(gone)) = (&self.gone, self.device.look()) {
            self.gone = Some(gone);
            self.peer.command(Command::Disarm);
        }
        let may_arm = !self.halted && self.gone.is_none();
        if self.peer.mode() == Mode::Disarmed && may_arm && self.line.inbox.newest().is_some() {
            self.peer.command(Command::Arm);
            self.peer.part();
            (self.begun, self.line.start) = (false, Start::default());
        }
        let (flow, parted) = self.line.inbox.take();
        let packets = flow.as_ref().map(packets_of);
        self.peer.arrive(Arrived { parted, packets: packets.as_ref(), late: self.line.link.is_old() });
        if self.peer.packet_due() {
            if let Some(packets) = self.peer.exchange() {
                let engaged = self.peer.is_engaged();
                self.line.start.say(now_us, engaged && (self.peer.is_whole() || !self.fades), engaged);
                let flow = flow_of(packets, self.peer.mode() == Mode::Armed, self.ticks);
                self.line.link.say(now_us, Flows { fading: !self.line.start.says(), ..flow }, &mut send);
            }
            self.begun |= self.line.start.both_us().is_some_and(|both_us| now_us >= both_us + self.after_us);
        }
        if self.until_telemetry == 0 {
            let telemetry = self.telemetry(now_us);
            // Without a session it is made up for as soon as there is one.
            if self.line.link.say(now_us, telemetry, &mut send) {
                self.until_telemetry = (self.telemetry_s / self.period_s) as u32;
            }
        } else {
            self.until_telemetry -= 1;
        }
        self.ticks = self.ticks.wrapping_add(1);
        let clutched = self.begun
            && self.peer.mode() == Mode::Armed
            && (self.clutch_is_held || self.device.clutches(self.armed_ticks as f64 * self.period_s));
        if clutched != self.clutched {
            self.clutched = clutched;
            self.peer.command(if clutched { Command::Clutch } else { Command::Release });
        }
        let actuators = self.peer.tick(&self.device.sensors());
        if self.is_moving() {
            self.device.step(self.armed_ticks as f64 * self.period_s, &actuators);
            self.armed_ticks += 1;
        } else if self.peer.mode() == Mode::Armed {
            // A hand that waits for the other one does nothing; a motor that is on moves what it holds.
            self.device.wait(&actuators);
        } else {
            self.device.idle();
        }
        actuators
    }

    /// Whether its hand moves: both ends were live, and its motors are on, or off for a fault.
    pub fn is_moving(&self) -> bool {
        match self.peer.mode() {
            Mode::Armed => self.begun,
            mode => mode != Mode::Disarmed,
        }
    }

    /// Turns its motors off and keeps them so, or lets them be armed again by what is heard.
    pub fn halt(&mut self, halted: bool) {
        self.halted = halted;
        if halted {
            self.peer.command(Command::Disarm);
        }
    }

    /// Holds its clutch open while it is armed, or leaves that to the device again.
    pub fn hold_clutch(&mut self, open: bool) {
        self.clutch_is_held = open;
    }

    /// Lets other forces act on a simulated device beside the user's from the next tick on: along each axis, N toward positive x, y, z.
    pub fn pull(&mut self, forces_n: [f64; N]) {
        self.device.pull(forces_n);
    }

    /// Motion of the node's device along each of its axes, m and m/s.
    pub fn motions(&self) -> [Motion<f64>; N] {
        self.device.motions()
    }

    /// Why its device is driven no more, if so: its motors stay off.
    pub fn gone(&self) -> Option<&Gone> {
        self.gone.as_ref()
    }

    /// What stopped it, or its device, in words.
    pub fn fault(&self) -> Option<String> {
        match self.peer.mode() {
            Mode::Faulted(fault) => Some(format!("fault {}: {}", fault.number(), fault.explain())),
            _ => self.gone().map(ToString::to_string),
        }
    }

    /// Whether its motors are kept off.
    pub fn is_halted(&self) -> bool {
        self.halted
    }

    /// Force of the wall that its device can meet, N; 0 without one.
    pub fn wall_n(&self) -> f64 {
        self.device.wall_n()
    }

    /// Motions and forces of the last tick along the first shared axis.
    pub fn observed(&self) -> &Observed<f32> {
        self.peer.observed()[0]
    }

    /// Notifies the other peer that this one ends its session.
    pub fn goodbye(&mut self, now_us: u64, send: impl FnMut(&[u8])) {
        self.line.link.say(now_us, Goodbye {}, send);
    }

    /// Numbers of its mode and its fault, or of that of its device.
    pub fn mode_and_fault(&self) -> [u8; 2] {
        match (self.peer.mode(), &self.gone) {
            (Mode::Armed, _) => [1, 0],
            (Mode::Faulted(fault), _) => [2, fault.number()],
            (_, gone) => gone.as_ref().map_or([0; 2], |gone| [2, gone.fault as u8]),
        }
    }

    /// How this one is doing, for the other end's people and logs: along the first shared axis, with the energies of all.
    fn telemetry(&self, now_us: u64) -> Telemetry {
        let (seen, ledgers) = (self.observed(), self.peer.ledger());
        let sum = |each: fn(&Ledger<f32>) -> f32| ledgers.iter().map(|ledger| f64::from(each(ledger))).sum();
        let [mode, fault] = self.mode_and_fault();
        let mut telemetry = Telemetry {
            mode,
            fault,
            tick: self.ticks,
            device_position: seen.device.position,
            object_position: seen.object.position,
            desired_position: seen.desired.position,
            contact_force: seen.contact_force,
            coordination_force: seen.coordination_force,
            energy_received: sum(Ledger::received_j),
            energy_sent: sum(Ledger::sent_j),
            ..Telemetry::default()
        };
        self.line.link.describe(now_us, &mut telemetry);
        telemetry
    }
}

/// What is known of a device that is simulated.
impl<const SHARED: usize, const N: usize> Node<SHARED, N> {
    /// What a reset leaves: the device, in a hand that holds it still.
    pub fn device(&self) -> Plant<N> {
        let mut plant = (*self.device).clone();
        plant.rest();
        plant
    }
}
