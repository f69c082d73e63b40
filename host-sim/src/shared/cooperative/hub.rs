//! A hub: where 2 to 16 peers hold one object over a real network, whoever brings the time and the datagrams.
//!
//! To each of its peers the hub looks like the other one: a sealed link, and flow each packet period. Behind the links the
//! wave lines meet ([`Junction`]). So peers, boards too, need nothing new for it. Each control period: [`Hub::receive`] for
//! every datagram that came, then [`Hub::tick`].
//!
//! **Lines.** Line n has its own key, made from the hub's (`host-sim key generate --line n --of`): a peer that is opened gives up
//! its own line and no other. The peer on an odd line is number 1 of the scene, on an even one number 2. Peers know nothing
//! of lines: a greeting is for the line under whose key it is authentic, a sealed datagram for the one whose session it
//! names. Addresses prove nothing; a peer is answered where it last proved itself from.
//!
//! **Who begins.** Wave lines know no positions, so all copies must begin at once from where they meet: until every line has
//! a session the hub sends no flow; host-sim's peers then do not arm, and boards are to be armed when the hub says that all
//! are there. Then it goes on whoever falls silent; one that comes back finds the object where its own device is.
//!
//! **Cost** of a datagram: one opening; of a greeting, a tag for each line at the most.

use haptic_protocol::peer::{flow_of, packet_of};
use haptic_protocol::wire::{Goodbye, Greeting, Header, MAX_DATAGRAM, Message, Telemetry};
use haptic_protocol::{key::Key, link::Stage};
use haptic_sim::node::{Line, Says as _, TELEMETRY_S};
use haptic_sim::scene::Scene;

use super::MOST_USERS;
use super::junction::{Junction, Port};

/// The hub's end of one line.
#[derive(Debug)]
pub struct End<A> {
    /// The sealed line.
    pub line: Line,
    /// Where its peer last proved itself from.
    pub(crate) address: Option<A>,
}

impl<A: Copy> End<A> {
    fn say(&mut self, now_us: u64, message: impl Into<Message>, send: &mut impl FnMut(A, &[u8])) {
        if let Some(address) = self.address {
            self.line.link.say(now_us, message, |bytes| send(address, bytes));
        }
    }
}

/// Which number of the scene the peer on a line has, lines counted from 1.
pub fn number_on(line: u32) -> u8 {
    if line % 2 == 1 { 1 } else { 2 }
}

/// Lines that meet.
#[derive(Debug)]
pub struct Hub<A> {
    ends: Vec<End<A>>,
    /// Where the lines meet.
    pub junction: Junction,
    ticks_per_packet: u32,
    telemetry_ticks: u32,
    /// Control periods since the start.
    ticks: u32,
    /// Packet periods since all were there; none before.
    pub packets: Option<u64>,
    /// Datagrams that no line took.
    pub(crate) refused: u64,
}

impl<A: Copy> Hub<A> {
    /// A hub for `users` peers of a scene, on lines 1 to `users`; `entropy` must never give the same twice.
    pub fn new(
        scene: &Scene,
        users: usize,
        key: &Key,
        mut entropy: impl FnMut() -> Result<[u8; Key::LEN], String>,
    ) -> Result<Self, String> {
        if !(2..=MOST_USERS).contains(&users) {
            return Err(format!("{users} users are not allowed: it must be a whole number from 2 to {MOST_USERS}"));
        }
        scene.check("hub").map_err(|refused| refused.to_string())?;
        let mut junction = Junction::new(scene, users).map_err(|error| error.to_string())?;
        if !scene.peer.coordination.ledger {
            return Err(
                "coordination.ledger = false is not allowed: it must be true, for on a network that may lose a packet \
                        only waves that are paid for keep a hub passive"
                    .to_owned(),
            );
        }
        let end = |at| Ok(End { line: Line::open(scene, 3 - number_on(at), key.line(at), entropy()?)?, address: None });
        let ends = (1..=users as u32).map(end).collect::<Result<Vec<_>, String>>()?;
        (0..users).for_each(|line| junction.part(line));
        let timing = &scene.peer.timing;
        Ok(Self {
            ends,
            junction,
            ticks_per_packet: timing.ticks_per_packet,
            telemetry_ticks: (TELEMETRY_S / timing.control_period_s) as u32,
            ticks: 0,
            packets: None,
            refused: 0,
        })
    }

    /// The lines, each with its port.
    pub fn lines(&self) -> impl Iterator<Item = (&End<A>, &Port)> {
        self.ends.iter().zip(&self.junction.ports)
    }

    /// Takes a datagram that came from `from`, opened in place, and sends what the link answers at once.
    pub fn receive(&mut self, now_us: u64, from: A, datagram: &mut [u8], mut send: impl FnMut(A, &[u8])) {
        let greeting = datagram.get(1).is_some_and(|kind| Greeting::is_kind(*kind));
        let session = Header::parse(datagram).ok().map(|(header, ..)| header.session);
        for (End { line, address }, at) in self.ends.iter_mut().zip(0..) {
            if !greeting && (session.is_none() || line.link.session_number() != session) {
                continue;
            }
            if line.receive(now_us, self.ticks, datagram, || self.junction.part(at)).is_err() {
                continue;
            }
            if !greeting {
                *address = Some(from);
            }
            let address = address.unwrap_or(from);
            line.link.say_due(now_us, |out| {
                // A greeting may be an old one, sent again by anybody: it is answered there, and nothing else goes there.
                let answers = !greeting || out.get(1).is_some_and(|kind| Greeting::is_kind(*kind));
                send(if answers { from } else { address }, out);
            });
            return;
        }
        self.refused += 1;
    }

    /// One control period: exchanges if that is due, says what is to be said.
    pub fn tick(&mut self, now_us: u64, mut send: impl FnMut(A, &[u8])) {
        let mut out = [0; MAX_DATAGRAM];
        for (End { line, address }, at) in self.ends.iter_mut().zip(0..) {
            while let Some(len) = line.link.poll(now_us, &mut out) {
                // A line that nobody has proved to be on is not called: its peer calls.
                if let Some(address) = address.filter(|_| line.link.stage() != Stage::Calling) {
                    send(address, &out[..len]);
                }
            }
            line.heed(now_us, || self.junction.part(at));
        }
        if self.ticks.is_multiple_of(self.ticks_per_packet) {
            if self.packets.is_none() && self.ends.iter().all(|end| end.line.link.is_up()) {
                self.packets = Some(0);
            }
            if self.packets.is_some() {
                self.exchange(now_us, &mut send);
            }
        }
        if self.ticks.is_multiple_of(self.telemetry_ticks.max(1)) {
            self.tell(now_us, &mut send);
        }
        self.ticks = self.ticks.wrapping_add(1);
    }

    /// Tells all peers that this is the end.
    pub fn goodbye(&mut self, now_us: u64, mut send: impl FnMut(A, &[u8])) {
        self.ends.iter_mut().for_each(|end| end.say(now_us, Goodbye {}, &mut send));
    }

    /// One packet period: what came of every line through the junction and back.
    fn exchange(&mut self, now_us: u64, send: &mut impl FnMut(A, &[u8])) {
        let mut came = [None; MOST_USERS];
        for ((End { line, .. }, at), came) in self.ends.iter_mut().zip(0..).zip(&mut came) {
            line.inbox.play(self.ticks);
            let (flow, anew) = line.inbox.take();
            if anew {
                self.junction.part(at);
            }
            *came = flow.as_ref().map(packet_of);
        }
        self.junction.exchange(came);
        self.packets = self.packets.map(|packets| packets + 1);
        for (end, port) in self.ends.iter_mut().zip(&self.junction.ports) {
            let flow = flow_of(port.back, true, self.ticks);
            end.say(now_us, flow, send);
        }
    }

    /// How the hub is doing, for the peers' people and logs: its own end of each line.
    fn tell(&mut self, now_us: u64, send: &mut impl FnMut(A, &[u8])) {
        let at = self.junction.motion.position as f32;
        for (end, port) in self.ends.iter_mut().zip(&self.junction.ports) {
            let mut telemetry = Telemetry {
                mode: u8::from(self.packets.is_some()),
                tick: self.ticks,
                device_position: at,
                object_position: at,
                desired_position: at,
                coordination_force: self.junction.force_n(port) as f32,
                energy_received: port.energy.taken_j,
                energy_sent: port.energy.sent_j,
                ..Telemetry::default()
            };
            end.line.link.describe(now_us, &mut telemetry);
            end.say(now_us, telemetry, send);
        }
    }
}
