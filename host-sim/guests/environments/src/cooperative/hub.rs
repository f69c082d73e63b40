//! A hub: where 2 to 16 peers hold one object over a real network, whoever brings the time and the datagrams.
//!
//! To each of its peers the hub looks like the other one: a sealed link, and flow each packet period, with the packets of all shared
//! axes in it. Behind the links the wave lines meet along each axis ([`Junction`]). So peers, boards too, need nothing new for it. Each
//! control period: [`Hub::receive`] for every datagram that came, then [`Hub::tick`].
//!
//! **Lines.** Line n has its own key, made from the hub's (`cohold key generate --line n --of`): a peer that is opened gives up
//! its own line and no other. The peer on an odd line is number 1 of the scene, on an even one number 2. Peers know nothing
//! of lines: a greeting is for the line under whose key it is authentic, a sealed datagram for the one whose session it
//! names. Addresses prove nothing; where a peer is answered is its line's path (`path.rs`).
//!
//! **Who begins.** Wave lines know no positions, so all copies must begin at once from where they meet: until every line has
//! a session the hub sends no flow; cohold's peers then do not arm, and boards are to be armed when the hub says that all
//! are there. A line whose peer was refused is not waited for, nor anybody once [`Hub::begin_without_absent`] was said, as
//! long as two are there. Then it goes on whoever falls silent; one that comes back, or late, finds the object where its own
//! device is.
//!
//! **A refused line does not stop the others.** A peer that has other parameters, another key or number, or says what
//! cannot be ([`cohold_core::law::bounds`]), is refused on its line, reported at both ends ([`Hub::news`]), and the others go on.
//! Whoever greets without a line's key is answered once a second at the most, with no more bytes, by a greeting from which its link
//! gathers why.
//!
//! **Cost** of a datagram: one opening; of a greeting, a tag for each line at the most, for 8 in a control period;
//! what comes on top of those is dropped unread, so that a flood of greetings takes no time from the lines that are up.

use std::fmt::Display;

use cohold_live::node::{Line, TELEMETRY_S};
use cohold_live::refused::{Refused, is_telling, wrong};
use cohold_protocol::end::End as _;
use cohold_protocol::link::{Config, Error, Link};
use cohold_protocol::parameters::Parameters;
use cohold_protocol::peer::{flow_of, packets_of};
use cohold_protocol::wire::{Flows, Goodbye, Greeting, Header, MAX_DATAGRAM, Message, PeerId, Telemetry};
use cohold_protocol::{ends::Ends, key::Key};
use cohold_sim::scene::Scene;

use super::MOST_USERS;
use super::junction::{Junction, Port};
use cohold_protocol::path::Path;

/// Greetings that are looked at in a control period.
const GREETINGS: u32 = 8;
/// Between two answers to those who are on no line, µs.
const ANSWER_EVERY_US: u64 = 1_000_000;
/// How long those whose lines are live wait for those who are there and whose are not, µs.
const MOST_WAITED_US: u64 = 2_000_000;

/// The hub's end of one line.
#[derive(Debug)]
pub struct End<A, const SHARED: usize = 1> {
    /// The sealed line to its peer.
    pub line: Line<SHARED>,
    /// Where its peer is answered.
    path: Path<A>,
    /// Who was refused on it, and why.
    pub(crate) refused: Refused<A>,
    /// The link that a peer of the other number under this line's key would talk to. It only reads.
    crossed: Link,
}

impl<A: Copy + PartialEq, const SHARED: usize> End<A, SHARED> {
    /// Where its peer is answered.
    pub(crate) fn address(&self) -> Option<A> {
        self.path.address()
    }

    fn say(&mut self, now_us: u64, message: impl Into<Message>, send: &mut impl FnMut(A, &[u8])) {
        let Self { line, path, .. } = self;
        line.link.say(now_us, message, |bytes| {
            if let Some(address) = path.of(bytes, None) {
                send(address, bytes);
            }
        });
    }
}

/// A link from peer `local` of two to the other, under a key, without parameters that must agree.
fn bare(key: Key, local: u8, entropy: [u8; Key::LEN]) -> Result<Link, crate::Error> {
    let ends = Ends { local: PeerId(local), remote: PeerId(3 - local) };
    let config = Config { key, ends, packet_period_us: 100_000, parameters: Parameters::new(), entropy };
    Ok(Link::new(config)?)
}

/// The peer of the scene (1 or 2) that a line stands for, lines counted from 1.
pub fn number_on(line: u32) -> u8 {
    if line % 2 == 1 { 1 } else { 2 }
}

/// A hub at which sealed lines of an object meet that is shared along `SHARED` axes.
#[derive(Debug)]
pub struct Hub<A, const SHARED: usize = 1> {
    ends: Vec<End<A, SHARED>>,
    /// Where the lines meet.
    pub junction: Junction<SHARED>,
    ticks_per_packet: u32,
    telemetry_ticks: u32,
    /// Control periods since the start.
    ticks: u32,
    /// Packet periods since all were there; none before.
    pub packets: Option<u64>,
    /// Datagrams that no line took.
    pub(crate) refused: u64,
    /// Who is on no line, and why.
    strangers: Refused<A>,
    /// What they are answered by, from peer 1 and from peer 2; the hub's own key is nobody's on a line.
    heralds: [Link; 2],
    next_answer_us: u64,
    /// Greetings that may be looked at yet in this control period.
    greetings: u32,
    waits: bool,
    /// Since when two lines are live.
    live_us: Option<u64>,
    /// Everybody may move.
    begun: bool,
}

impl<A: Copy + PartialEq + Display, const SHARED: usize> Hub<A, SHARED> {
    /// A hub for `users` peers of a scene, on lines 1 to `users`; `entropy` must never give the same twice.
    ///
    /// # Errors
    /// A scene that cannot be built, or of another number of shared axes; or no random bytes.
    pub fn new(
        scene: &Scene,
        users: usize,
        key: &Key,
        mut entropy: impl FnMut() -> Result<[u8; Key::LEN], cohold_sim::Error>,
    ) -> Result<Self, crate::Error> {
        if !(2..=MOST_USERS).contains(&users) {
            return Err(
                format!("{users} users are not allowed: it must be a whole number from 2 to {MOST_USERS}").into()
            );
        }
        scene.check("hub")?;
        let mut junction = Junction::new(scene, users)?;
        if scene.law().scatters && !scene.peer.coordination.ledger {
            let allowed = "it must be true, for on a network that may lose a packet only waves that are paid for keep \
                           a hub passive";
            return Err(cohold_sim::Error::not_allowed("coordination.ledger = false", allowed).into());
        }
        let heralds = [bare(key.clone(), 1, entropy()?)?, bare(key.clone(), 2, entropy()?)?];
        let end = |at| {
            let (key, number) = (key.line(at), number_on(at));
            let crossed = bare(key.clone(), number, entropy()?)?;
            let mut line = Line::open(scene, 3 - number, key, entropy()?)?;
            // On a line of its own a peer says no more than one may, along any axis.
            line.inbox.bound(scene.laws.bounds(&scene.peers()[usize::from(number == 2)]));
            Ok(End { line, path: Path::default(), refused: Refused::default(), crossed })
        };
        let ends = (1..=users as u32).map(end).collect::<Result<Vec<_>, crate::Error>>()?;
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
            strangers: Refused::default(),
            heralds,
            next_answer_us: 0,
            greetings: GREETINGS,
            waits: true,
            live_us: None,
            begun: false,
        })
    }

    /// The datagram that is taken next has waited for so long since it came, µs ([`Link::waited`]).
    pub(crate) fn waited(&mut self, us: u64) {
        self.ends.iter_mut().for_each(|end| end.line.link.waited(us));
    }

    /// The lines, each with its port.
    pub fn lines(&self) -> impl Iterator<Item = (&End<A, SHARED>, &Port<SHARED>)> {
        self.ends.iter().zip(&self.junction.ports)
    }

    /// Takes a datagram that came from `from`, opened in place, and sends what the link answers at once.
    pub fn receive(&mut self, now_us: u64, from: A, datagram: &mut [u8], mut send: impl FnMut(A, &[u8])) {
        let greeting = datagram.get(1).is_some_and(|kind| Greeting::is_kind(*kind));
        if greeting {
            let Some(left) = self.greetings.checked_sub(1) else { return self.refused += 1 };
            self.greetings = left;
        }
        let session = Header::parse(datagram).map(|(header, ..)| header.session);
        let mut why = session.err().filter(|_| !greeting).map(Error::Wire);
        for End { line, path, refused, .. } in &mut self.ends {
            if !greeting && (session.is_err() || line.link.session_number() != session.ok()) {
                continue;
            }
            let taken = line.receive(now_us, self.ticks, datagram);
            path.heard(now_us, from, datagram, taken.is_ok(), &line.link);
            match taken {
                Ok(_) => {}
                // What this line's peer itself has sent is for nobody else.
                Err(refusal) if !greeting || matches!(refusal, Error::Parameters(_)) => {
                    self.refused += 1;
                    if is_telling(&refusal) {
                        refused.note(from, refusal);
                    }
                    return;
                }
                Err(refusal) => {
                    // Of several lines, the one with the right numbers has read furthest.
                    let numbers = matches!(refusal, Error::OwnNumber | Error::Stranger | Error::NotForUs);
                    why = why.filter(|_| numbers).or(Some(refusal));
                    continue;
                }
            }
            line.link.say_due(now_us, |out| _ = path.of(out, Some(from)).map(|address| send(address, out)));
            return;
        }
        self.refused += 1;
        if let Some(why) = why.filter(is_telling) {
            self.puzzle(now_us, from, datagram, why, send);
        }
    }

    /// Finds out for a person, and lets whoever called find out, why a datagram is of no line.
    fn puzzle(&mut self, now_us: u64, from: A, datagram: &mut [u8], why: Error, mut send: impl FnMut(A, &[u8])) {
        if now_us < self.next_answer_us {
            return self.strangers.note(from, why);
        }
        self.next_answer_us = now_us + ANSWER_EVERY_US;
        let number = Greeting::parse(datagram).map_or(1, |(greeting, ..)| greeting.from.0.clamp(1, 2));
        // Bare links were given nothing, so that a fresh greeting would differ, but nobody has a challenge of theirs.
        let mut crossed = self.ends.iter_mut().filter_map(|end| {
            let End { crossed, refused, .. } = end;
            crossed.receive(now_us, datagram).is_ok().then_some(refused)
        });
        // To someone who has the number of this end, from that; else from where it wants to.
        let herald = match crossed.next() {
            Some(refused) => {
                refused.note(from, Error::OwnNumber);
                number
            }
            None => {
                self.strangers.note(from, why);
                3 - number
            }
        };
        let mut out = [0; MAX_DATAGRAM];
        if let Some(len) = self.heralds[usize::from(herald) - 1].poll(now_us, &mut out)
            && len <= datagram.len()
        {
            send(from, &out[..len]);
        }
    }

    /// What there is to tell a person about those who are refused; nothing most of the time, and never much.
    pub fn news(&mut self, now_us: u64) -> Vec<String> {
        let lines = (1_u32..).zip(&mut self.ends).filter_map(|(line, end)| {
            let (from, why) = end.refused.take(now_us)?;
            Some(format!("line {line}: {}", line_wrong(line, from, &why)))
        });
        let strangers = self.strangers.take(now_us).map(|(from, why)| format!("on no line: {}", wrong(from, &why)));
        lines.chain(strangers).collect()
    }

    /// Why the newest datagram that is of no line was refused.
    pub(crate) fn stranger(&self) -> Option<String> {
        self.strangers.newest.map(|(from, why)| wrong(from, &why))
    }

    /// Waits no more for those who are not there, if two are.
    pub fn begin_without_absent(&mut self) {
        self.waits = false;
    }

    /// Whether everybody is there who is waited for.
    fn is_complete(&self) -> bool {
        let links = || self.ends.iter().map(|end| &end.line.link);
        let up = links().filter(|link| link.is_up()).count();
        up >= 2 && (!self.waits || links().all(|link| link.is_up() || link.refused().is_some()))
    }

    /// One control period: exchanges if that is due, says what is to be said.
    pub fn tick(&mut self, now_us: u64, mut send: impl FnMut(A, &[u8])) {
        self.greetings = GREETINGS;
        for End { line, path, .. } in &mut self.ends {
            line.link.say_due(now_us, |out| _ = path.of(out, None).map(|address| send(address, out)));
            line.heed(now_us);
        }
        let packets_due = self.ticks.is_multiple_of(self.ticks_per_packet);
        if packets_due && self.packets.is_none() && self.is_complete() {
            self.packets = Some(0);
        }
        if self.packets.is_some() && self.junction.is_due(packets_due) {
            self.exchange(now_us, packets_due, &mut send);
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

    /// What came of every line through the junction, and what goes back, where packets are due.
    fn exchange(&mut self, now_us: u64, packets_due: bool, send: &mut impl FnMut(A, &[u8])) {
        let mut came = [None; MOST_USERS];
        for ((End { line, .. }, at), came) in self.ends.iter_mut().zip(0..).zip(&mut came) {
            line.inbox.play(self.ticks);
            let (flow, parted) = line.inbox.take();
            if parted {
                self.junction.part(at);
            }
            *came = flow.as_ref().map(packets_of);
        }
        self.junction.exchange(came, packets_due);
        if !packets_due {
            return;
        }
        self.packets = self.packets.map(|packets| packets + 1);
        for ((End { line, .. }, port), at) in self.ends.iter_mut().zip(&self.junction.ports).zip(0..) {
            line.start.say(now_us, self.junction.is_whole(at), port.is_engaged());
        }
        self.begin(now_us);
        for (end, port) in self.ends.iter_mut().zip(&self.junction.ports) {
            let live = self.begun && end.line.start.says();
            let flow = Flows { fading: !live, ..flow_of(port.back(), true, self.ticks) };
            end.say(now_us, flow, send);
        }
    }

    /// Lets everybody begin, at once, when every line of those who are there is live at both ends; who is not
    /// [`MOST_WAITED_US`] after two others are does not keep them.
    fn begin(&mut self, now_us: u64) {
        let lines = || self.ends.iter().map(|end| &end.line);
        let live = lines().filter(|line| line.start.both_us().is_some()).count();
        if live >= 2 {
            let since_us = *self.live_us.get_or_insert(now_us);
            let there = lines().filter(|line| line.link.is_up()).count();
            self.begun |= live >= there || now_us >= since_us + MOST_WAITED_US;
        }
    }

    /// How the hub is doing, for the peers' people and logs: its own end of each line, along the first shared axis, with the energies of
    /// all.
    fn tell(&mut self, now_us: u64, send: &mut impl FnMut(A, &[u8])) {
        let at = self.junction.motion[0].position as f32;
        for (end, port) in self.ends.iter_mut().zip(&self.junction.ports) {
            let energy = port.energy();
            let mut telemetry = Telemetry {
                mode: u8::from(self.packets.is_some()),
                tick: self.ticks,
                device_position: at,
                object_position: at,
                desired_position: at,
                coordination_force: port.axes[0].force_n as f32,
                energy_received: energy.taken_j,
                energy_sent: energy.sent_j,
                ..Telemetry::default()
            };
            end.line.link.describe(now_us, &mut telemetry);
            end.say(now_us, telemetry, send);
        }
    }
}

/// What is wrong with whoever was refused on a line.
pub(crate) fn line_wrong(line: u32, from: impl Display, why: &Error) -> String {
    match why {
        Error::OwnNumber => {
            format!("{from} is peer {}: on this line it must be {}", 3 - number_on(line), number_on(line))
        }
        why => wrong(from, why),
    }
}
