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

use haptic_protocol::ends::Ends;
use haptic_protocol::key::Key;
use haptic_protocol::link::{Link, Notice, Stage};
use haptic_protocol::peer::{Inbox, flow_of, packet_of};
use haptic_protocol::wire::{Datagram, Greeting, Header, MAX_DATAGRAM, Message, PeerId, Telemetry};

use super::MOST_USERS;
use super::junction::{Junction, Port};
use haptic_sim::node::{TELEMETRY_S, open_link};
use haptic_sim::scene::Scene;

/// The hub's end of one line.
#[derive(Debug)]
pub struct Line<A> {
    /// The link.
    pub link: Link,
    /// Where its peer last proved itself from.
    pub address: Option<A>,
    /// What its peer last said about itself.
    pub heard: Option<Telemetry>,
    /// What the link has reported so far, in order, with the time of each in µs.
    pub notices: Vec<(u64, Notice)>,
    inbox: Inbox,
}

/// Which number of the scene the peer on a line has, lines counted from 1.
pub fn number_on(line: u32) -> u8 {
    if line % 2 == 1 { 1 } else { 2 }
}

/// Lines that meet.
#[derive(Debug)]
pub struct Hub<A> {
    lines: Vec<Line<A>>,
    junction: Junction,
    ticks_per_packet: u32,
    telemetry_ticks: u32,
    /// Control periods since the start.
    ticks: u32,
    /// Packet periods since all were there; none before.
    packets: Option<u64>,
    /// Datagrams that no line took.
    refused: u64,
    out: Datagram,
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
        let lines = (1..=users as u32).map(|line| {
            let number = number_on(line);
            let ends = Ends { local: PeerId(3 - number), remote: PeerId(number) };
            let link = open_link(scene, ends, key.line(line), entropy()?)?;
            let inbox = Inbox::new(scene.world.network.playout_packets, scene.peer.timing.ticks_per_packet);
            Ok(Line { link, address: None, inbox, heard: None, notices: Vec::new() })
        });
        let lines = lines.collect::<Result<Vec<_>, String>>()?;
        (0..users).for_each(|line| junction.part(line));
        let timing = &scene.peer.timing;
        Ok(Self {
            lines,
            junction,
            ticks_per_packet: timing.ticks_per_packet,
            telemetry_ticks: (TELEMETRY_S / timing.control_period_s) as u32,
            ticks: 0,
            packets: None,
            refused: 0,
            out: [0; MAX_DATAGRAM],
        })
    }

    /// The lines, each with its port.
    pub fn lines(&self) -> impl Iterator<Item = (&Line<A>, &Port)> {
        self.lines.iter().zip(self.junction.ports())
    }

    /// Where the lines meet.
    pub fn junction(&self) -> &Junction {
        &self.junction
    }

    /// Packet periods since all were there; none before.
    pub fn packets(&self) -> Option<u64> {
        self.packets
    }

    /// Datagrams that no line took.
    pub fn refused(&self) -> u64 {
        self.refused
    }

    /// Takes a datagram that came from `from`, opened in place, and sends what the link answers at once.
    pub fn receive(&mut self, now_us: u64, from: A, datagram: &mut [u8], mut send: impl FnMut(A, &[u8])) {
        let greeting = datagram.get(1).is_some_and(|kind| Greeting::is_kind(*kind));
        let session = Header::parse(datagram).ok().map(|(header, ..)| header.session);
        for (line, at) in self.lines.iter_mut().zip(0..) {
            if !greeting && (session.is_none() || line.link.session_number() != session) {
                continue;
            }
            let taken = line.link.receive(now_us, datagram);
            // Before the flow is kept: it may be the first of another life of the peer.
            Self::heed(line, &mut self.junction, at, now_us);
            let Ok(incoming) = taken else { continue };
            match incoming {
                Some(Message::Flow(flow)) => line.inbox.put(self.ticks, flow),
                Some(Message::Telemetry(telemetry)) => line.heard = Some(telemetry),
                _ => {}
            }
            if !greeting {
                line.address = Some(from);
            }
            while let Some(len) = line.link.poll(now_us, &mut self.out) {
                let out = &self.out[..len];
                // A greeting may be an old one, sent again by anybody: it is answered there, and nothing else goes there.
                let answers = !greeting || out.get(1).is_some_and(|kind| Greeting::is_kind(*kind));
                send(if answers { from } else { line.address.unwrap_or(from) }, out);
            }
            return;
        }
        self.refused += 1;
    }

    /// What a link has noticed.
    fn heed(line: &mut Line<A>, junction: &mut Junction, at: usize, now_us: u64) {
        while let Some(notice) = line.link.take_notice() {
            if notice == Notice::Disengaged {
                junction.part(at);
                line.inbox.clear();
            }
            line.notices.push((now_us, notice));
        }
    }

    /// One control period: exchanges if that is due, says what is to be said.
    pub fn tick(&mut self, now_us: u64, mut send: impl FnMut(A, &[u8])) {
        for (line, at) in self.lines.iter_mut().zip(0..) {
            while let Some(len) = line.link.poll(now_us, &mut self.out) {
                // A line that nobody has proved to be on is not called: its peer calls.
                if let Some(address) = line.address.filter(|_| line.link.stage() != Stage::Calling) {
                    send(address, &self.out[..len]);
                }
            }
            Self::heed(line, &mut self.junction, at, now_us);
        }
        if self.ticks.is_multiple_of(self.ticks_per_packet) {
            if self.packets.is_none() && self.lines.iter().all(|line| line.link.is_up()) {
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
        for line in &mut self.lines {
            if let Some((address, len)) = line.address.zip(line.link.goodbye(now_us, &mut self.out)) {
                send(address, &self.out[..len]);
            }
        }
    }

    /// One packet period: what came of every line through the junction and back.
    fn exchange(&mut self, now_us: u64, send: &mut impl FnMut(A, &[u8])) {
        let mut came = [None; MOST_USERS];
        for ((line, at), came) in self.lines.iter_mut().zip(0..).zip(&mut came) {
            line.inbox.play(self.ticks);
            let (flow, anew) = line.inbox.take();
            if anew {
                self.junction.part(at);
            }
            *came = flow.as_ref().map(packet_of);
        }
        self.junction.exchange(came);
        self.packets = self.packets.map(|packets| packets + 1);
        for (line, port) in self.lines.iter_mut().zip(self.junction.ports()) {
            let flow = flow_of(port.back, true, self.ticks);
            if let Some((address, len)) = line.address.zip(line.link.send(now_us, flow, &mut self.out)) {
                send(address, &self.out[..len]);
            }
        }
    }

    /// How the hub is doing, for the peers' people and logs: its own end of each line.
    fn tell(&mut self, now_us: u64, send: &mut impl FnMut(A, &[u8])) {
        let at = self.junction.motion.position as f32;
        for (line, port) in self.lines.iter_mut().zip(self.junction.ports()) {
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
            line.link.describe(now_us, &mut telemetry);
            if let Some((address, len)) = line.address.zip(line.link.send(now_us, telemetry, &mut self.out)) {
                send(address, &self.out[..len]);
            }
        }
    }
}
