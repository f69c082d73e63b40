//! Link: one peer's end of the wire to another. Bytes and `now` go in, bytes and messages come out.
//!
//! ```text
//! Calling ──proof──► Joining ─answered─► Idle ──flow──► Running ◄──3 silent, flow again──► Fading
//!    ▲  ▲ Refused ◄─other parameters      │ ▲                                               │
//!    │  └──────────────────────────12 silent└───────────────────no flow for 12──────────────┘
//! ```
//!
//! The caller owns socket, clock and buffers. Each packet period it sends its flow ([`Link::send`]); after every datagram that
//! came ([`Link::receive`]) and at least once a packet period it calls [`Link::poll`] until there is nothing more to send.
//! Nothing here waits, and the flow waits for nothing.
//!
//! **Freshness**: nothing is taken before the other end has answered in this session, and nothing that could be older than a
//! second, flow than [`Link::within`]; measured by this end's clock alone ([`crate::wire::Stamps`]). A session that stays
//! unconfirmed for a second, or 12 packet periods if that is longer, ends.
//!
//! **Lease**: every datagram has a byte in which an operator's end says whether motors may run, and a board whether they do
//! ([`Link::say_lease`], [`Link::heard`], [`crate::lease`]). So an attacker who drops or delays some of the datagrams keeps nothing running.
//!
//! **Units**: µs on the caller's own clock, which may start anywhere and must not go backwards (if it does, time stands
//! still). **Invariants**: bounded memory, the size of [`Link`] itself; a datagram that is not authentic changes nothing
//! but [`Counts::refused`]; one counter numbers all that this peer ever seals, so that no key meets a nonce twice.
//! **Limits**: one link leads to one peer; who is there is known by key and number, not by address.

use crate::engagement::{DISENGAGE_AFTER, Engagement};
use crate::handshake::{self, Handshake, LIFE_US};
use crate::reliable::{Receiver, Sender};
use crate::session::{Counter, Says, Session};
use crate::wire::{
    Challenge, Datagram, Event, Goodbye, Greeting, GreetingKind, MAX_DATAGRAM, Message, Probe, Reply, Telemetry,
};
use crate::{clock::Clock, ends::Ends, key::Key, notices::Notices, parameters::Parameters};

mod incoming;

pub use crate::error::Refusal as Error;
pub use crate::reliable::{Full, WINDOW as EVENTS};

/// Packet periods between hellos.
const HELLO_EVERY: u32 = 2;
/// One-way delay beyond which flow is not taken, unless [`Link::within`] says another, µs.
pub const MAX_DELAY_US: u32 = 250_000;
/// Packet periods between time probes.
const PROBE_EVERY: u32 = 8;
/// Packet periods without anything sent before a probe keeps the session alive.
const KEEP_ALIVE_AFTER: u32 = 2;
/// Notices kept for a caller that does not ask; then the oldest goes.
const NOTICES: usize = 16;

/// What a link is made from.
#[derive(Clone, Debug)]
pub struct Config {
    /// The key that both peers hold.
    pub key: Key,
    /// The two peers' numbers.
    pub ends: Ends,
    /// How often flow is sent, µs.
    pub packet_period_us: u32,
    /// The settings that both peers must share.
    pub parameters: Parameters,
    /// 32 random bytes, never the same at two starts of this peer: from a true random number generator.
    pub entropy: [u8; Key::LEN],
}

/// Why a link cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConfigError {
    /// Both ends were given the same number.
    #[error("both ends of a link have the number {0}: give one another")]
    SameNumber(u8),
    /// The shared key is all zeros: nobody has set it.
    #[error("the shared key is all zeros: make one and give it to both peers")]
    ZeroKey,
    /// The entropy is all zeros: the random number generator was not asked, or failed.
    #[error("the entropy is all zeros: the random number generator failed")]
    ZeroEntropy,
    /// The packet period, µs, is out of range.
    #[error("packet period = {us} µs is not allowed: it must be from {} to {} µs", Self::SHORTEST_US, Self::LONGEST_US)]
    PacketPeriod {
        /// What was asked for, µs.
        us: u32,
    },
}

impl ConfigError {
    /// The shortest packet period, µs.
    pub const SHORTEST_US: u32 = 100;
    /// The longest packet period, µs.
    pub const LONGEST_US: u32 = 10_000_000;
}

/// How far two peers have come with each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Stage {
    /// No session: saying hello.
    Calling = 0,
    /// The other peer has proved itself; keys are there, nothing has been answered under them yet.
    Joining = 1,
    /// Heard, but no flow comes: the other peer is there and does not coordinate.
    Idle = 2,
    /// Flow comes: the peers coordinate.
    Running = 3,
    /// Flow stays away; the coordination lets go.
    Fading = 4,
    /// The other peer has other parameters; this one still says hello, in case they are corrected.
    Refused = 5,
}

/// Something that has happened to a link; [`Link::take_notice`] tells each once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notice {
    /// A session is confirmed: there are fresh keys at both ends.
    Joined,
    /// The other peer has started anew since the last session, or is here for the first time. So many events that were under
    /// way are dropped.
    NewPeer(u8),
    /// Flow comes: begin the coordination from rest.
    Engaged,
    /// No flow for 3 packet periods.
    Fading,
    /// Flow again before the peers were apart.
    Resumed,
    /// The peers are apart: no flow for 12 packet periods ([`Link::disengage_after`]), or the session has ended.
    Disengaged,
    /// The session has ended: a goodbye, silence for 12 packet periods, or the other peer has started another one.
    Lost,
    /// Flow comes too late and is not taken: its delay one way, µs. Reported once, until flow is taken again.
    Old(u32),
    /// The other peer has other parameters: the name of the first table that differs.
    Refused(&'static str),
}

/// What a link has counted since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Sealed datagrams opened and accepted.
    pub taken: u32,
    /// Sealed datagrams of the other peer that never came.
    pub missing: u32,
    /// Flow that came after newer flow, dropped.
    pub late: u32,
    /// Flow whose delay was more than is allowed, dropped.
    pub old: u32,
    /// Datagrams refused, of any kind.
    pub refused: u32,
}

/// One peer's end of the wire to another.
#[derive(Debug)]
#[cfg_attr(test, derive(Clone))]
pub struct Link {
    ends: Ends,
    period_us: u32,
    /// From one flow to the next at most, µs: how often the link speaks by itself counts in this.
    pace_us: u32,
    handshake: Handshake,
    counter: Counter,
    session: Option<Session>,
    /// The incarnation of the other peer that the reliable events belong to.
    peer: Option<u64>,
    refused: Option<&'static str>,
    engagement: Engagement,
    clock: Clock,
    sender: Sender,
    receiver: Receiver,
    /// Sequence number of the newest flow taken in this session.
    newest_flow: Option<u64>,
    /// The delay of that, one way, µs; and the longest that is allowed.
    delay_us: Option<u32>,
    max_delay_us: u32,
    /// The newest flow was too old.
    is_old: bool,
    /// The newest challenge of the other end that came with an echo of a good one of ours, refused or not.
    far: Challenge,
    /// A welcome to send, and the challenge that it echoes.
    answer: Option<Challenge>,
    /// A probe to answer: its time, and when it came.
    probed: Option<(u64, u64)>,
    /// How long what is taken next has waited, µs; and when what was opened last was sealed, µs of the other end's clock.
    waited_us: u64,
    sealed_us: u64,
    ack_due: bool,
    /// When the newest probe was sent that was answered in this session.
    answered_us: Option<u64>,
    heard_us: u64,
    sent_us: u64,
    next_hello_us: u64,
    next_probe_us: u64,
    says: Says,
    told: Stage,
    notices: Notices<Notice, NOTICES>,
    past: Counts,
}

impl Link {
    /// A link that begins to call at its first [`Link::poll`].
    ///
    /// # Errors
    /// Two ends with one number, or a packet period out of range.
    pub fn new(config: Config) -> Result<Self, ConfigError> {
        let Config { key, ends, packet_period_us, parameters, entropy } = config;
        let entropy = Key::new(entropy);
        if ends.local == ends.remote {
            return Err(ConfigError::SameNumber(ends.local.0));
        }
        if key.is_zero() {
            return Err(ConfigError::ZeroKey);
        }
        if entropy.is_zero() {
            return Err(ConfigError::ZeroEntropy);
        }
        if !(ConfigError::SHORTEST_US..=ConfigError::LONGEST_US).contains(&packet_period_us) {
            return Err(ConfigError::PacketPeriod { us: packet_period_us });
        }
        Ok(Self {
            ends,
            period_us: packet_period_us,
            pace_us: packet_period_us,
            handshake: Handshake::new(key, ends, parameters, &entropy),
            counter: Counter::default(),
            session: None,
            peer: None,
            refused: None,
            engagement: Engagement::new(packet_period_us, 0),
            clock: Clock::default(),
            sender: Sender::default(),
            receiver: Receiver::default(),
            newest_flow: None,
            delay_us: None,
            max_delay_us: MAX_DELAY_US,
            is_old: false,
            far: Challenge::default(),
            answer: None,
            probed: None,
            waited_us: 0,
            sealed_us: 0,
            ack_due: false,
            answered_us: None,
            heard_us: 0,
            sent_us: 0,
            next_hello_us: 0,
            next_probe_us: 0,
            says: Says::default(),
            told: Stage::Calling,
            notices: Notices::default(),
            past: Counts::default(),
        })
    }

    /// Whether a datagram is a greeting that a link with this key between these ends, on line `number` ([`Link::on_line`]), would read: a
    /// server makes a link only for whoever holds the line's key. It costs two hashes and no multiplication.
    ///
    /// # Errors
    /// Why such a link would refuse it.
    pub fn is_called(key: &Key, ends: Ends, number: u32, datagram: &[u8]) -> Result<(), Error> {
        handshake::is_called(key, ends, number, datagram)
    }

    /// This link on line `number` of a server that has a line for each of its clients; the key of the configuration
    /// must be that line's ([`Key::line`]). A server tells greetings apart by their line and sealed datagrams by
    /// their session ([`Link::session_number`]), so that neither addresses nor the 256 peer numbers limit it.
    pub fn on_line(mut self, number: u32) -> Self {
        self.handshake.set_line(number);
        self
    }

    /// This link, but the session and the engagement end only after `silence_us` µs without a datagram, if that is
    /// longer than 12 packet periods and than 96 ms.
    pub fn disengage_after(mut self, silence_us: u32) -> Self {
        self.engagement = Engagement::new(self.period_us, silence_us);
        self
    }

    /// This link, which takes flow only while its one-way delay is at most `max_delay_us` µs. The delay is half of
    /// the measured round trip, from when this end sealed the newest datagram that the flow's sender had opened to
    /// when the flow came; so whatever happens on the path, no flow that is taken is older than twice as much. Challenges and messages count
    /// for 2.5 times the delay, at most 2.5 s, if that is more than 1 s: so sessions can be made wherever flow is taken.
    pub fn within(mut self, max_delay_us: u32) -> Self {
        self.max_delay_us = max_delay_us;
        self.handshake.life_us = LIFE_US.max(u64::from(max_delay_us.min(1_000_000)) * 5 / 2);
        self
    }

    /// This link, for flow that is sent only when it is worth it, every `longest_us` µs at the latest: it probes as
    /// seldom as the flow may come. The silence that ends a session stays as it is.
    pub fn keeping_silent(mut self, longest_us: u32) -> Self {
        self.pace_us = longest_us.max(self.period_us);
        self
    }

    /// This link, whose messages of less than `bytes` bytes are all sealed as if they had so many, so that their kinds cannot be told
    /// apart by their lengths. None gets more than 127 zeros ([`crate::wire::Stamps::MAX_PADDING`]).
    pub fn of_one_length(mut self, bytes: usize) -> Self {
        self.says.least = bytes;
        self
    }

    /// Says this byte about the lease in every datagram from now on, at first 0. Another byte than before is said at the next
    /// [`Link::poll`]. If the link is eager, it says something in every packet period.
    pub fn say_lease(&mut self, lease: u8, is_eager: bool) {
        if self.says.lease != lease {
            self.next_probe_us = 0;
        }
        (self.says.lease, self.says.is_eager) = (lease, is_eager);
    }

    /// The byte about the lease in the newest datagram of a confirmed session, and the newest time of this end's clock that its sender
    /// knew, µs.
    pub fn heard(&self) -> Option<(u8, Option<u64>)> {
        self.session.as_ref().filter(|session| session.is_confirmed()).and_then(Session::heard)
    }

    /// The number in the header of every sealed datagram of the session at hand, both ways.
    pub fn session_number(&self) -> Option<u32> {
        self.session.as_ref().map(Session::number)
    }

    /// Lets time pass, and gives the length of the next datagram to send, written to the front of `out`; `None` when there
    /// is nothing to send for now.
    pub fn poll(&mut self, now: u64, out: &mut Datagram) -> Option<usize> {
        self.advance(now);
        if let Some(echo) = self.answer.take() {
            return self.handshake.greet(now, GreetingKind::Welcome, echo, out).ok();
        }
        let confirmed = self.session.as_ref().is_some_and(Session::is_confirmed);
        if !confirmed && now >= self.next_hello_us {
            self.next_hello_us = self.after(now, HELLO_EVERY);
            // Who was refused is refused again, and so learns of it.
            let far = self.session.is_some() || self.refused.is_some();
            let echo = if far { self.far } else { Challenge::default() };
            return self.handshake.greet(now, GreetingKind::Hello, echo, out).ok();
        }
        let message = self.due(now, confirmed)?;
        self.seal(now, &message, out)
    }

    /// What is to be said to the other peer beside the flow.
    fn due(&mut self, now: u64, confirmed: bool) -> Option<Message> {
        self.session.as_ref()?;
        if let Some((probe_sent_us, probe_received_us)) = self.probed.take() {
            return Some(Message::Reply(Reply { probe_sent_us, probe_received_us, sent_us: now }));
        }
        if core::mem::take(&mut self.ack_due) {
            return Some(Message::Ack(self.receiver.ack()));
        }
        if confirmed {
            let timeout = self.clock.timeout_us(u64::from(self.period_us).saturating_mul(2));
            if let Some(event) = self.sender.due(now, timeout) {
                return Some(Message::Event(event));
            }
        }
        let due =
            if self.says.is_eager { self.after(self.sent_us, 1) } else { self.paced(self.sent_us, KEEP_ALIVE_AFTER) };
        if now >= self.next_probe_us || now >= due {
            self.next_probe_us = if confirmed { self.paced(now, PROBE_EVERY) } else { self.after(now, 1) };
            return Some(Message::Probe(Probe { sent_us: now }));
        }
        None
    }

    /// Seals a message into `out` and gives the datagram's length; `None` while there is no session, or when a number in it is
    /// not finite. An event is taken in charge as by [`Link::push_event`] and comes with a later [`Link::poll`]; what the link says
    /// by itself (acknowledgements, probes, replies) it sends for nobody else.
    pub fn send(&mut self, now: u64, message: impl Into<Message>, out: &mut Datagram) -> Option<usize> {
        self.advance(now);
        match message.into() {
            Message::Event(event) => {
                // No room: whoever has to be sure asks [`Link::push_event`].
                let _ = self.push_event(event);
                None
            }
            Message::Goodbye(_) => self.goodbye(now, out),
            Message::Ack(_) | Message::Probe(_) | Message::Reply(_) => None,
            message => self.seal(now, &message, out),
        }
    }

    /// Sends a message, sealed, by `send`; false if there is no session to send it in. `now` is the time, µs.
    pub fn say(&mut self, now: u64, message: impl Into<Message>, send: impl FnMut(&[u8])) -> bool {
        let mut out = [0; MAX_DATAGRAM];
        self.send(now, message, &mut out).and_then(|len| out.get(..len)).map(send).is_some()
    }

    /// Sends what is due of the link's own messages by `send`: calls, answers, events, probes. `now` is the time, µs.
    pub fn say_due(&mut self, now: u64, mut send: impl FnMut(&[u8])) {
        let mut out = [0; MAX_DATAGRAM];
        while let Some(bytes) = self.poll(now, &mut out).and_then(|len| out.get(..len)) {
            send(bytes);
        }
    }

    /// Seals a goodbye into `out` and ends the session; `None` as for [`Link::send`]. The other end then knows at once what it
    /// would otherwise gather from 12 packet periods of silence. Said once: lost, it is the silence after all. A link that is
    /// polled on calls anew.
    pub fn goodbye(&mut self, now: u64, out: &mut Datagram) -> Option<usize> {
        self.advance(now);
        let len = self.seal(now, &Message::Goodbye(Goodbye {}), out);
        self.end();
        len
    }

    /// Queues an event for reliable delivery, once and in order, unless the other peer goes. Gives its number.
    ///
    /// # Errors
    /// As many events are under way as there is room for.
    pub fn push_event(&mut self, event: Event) -> Result<u32, Full> {
        self.sender.push(event)
    }

    /// The next event of the other peer, once and in order.
    pub fn take_event(&mut self) -> Option<Event> {
        self.receiver.take()
    }

    /// Events of this peer that have not been acknowledged.
    pub fn events_under_way(&self) -> usize {
        self.sender.under_way()
    }

    /// When the newest probe was sent that has been answered in this session, µs: whoever answers at an address has heard what was
    /// sent there.
    pub fn answered_us(&self) -> Option<u64> {
        self.answered_us
    }

    /// How long the newest flow took, one way, µs, whether it was taken or too old: half of the way there and back, a packet period
    /// or two of waiting at the other end included.
    pub fn delay_us(&self) -> Option<u32> {
        self.delay_us
    }

    /// 6 of the longest silences between what the other end says, µs, half of what ends a session at the least: where nothing came from
    /// for so long, it is not there any more.
    pub fn quiet_us(&self) -> u64 {
        Engagement::new(self.pace_us, 0).disengage_after_us() / 2
    }

    /// Whether flow comes and is too old to be taken.
    pub fn is_old(&self) -> bool {
        self.is_old
    }

    /// The newest time of the other end's clock that is known here, µs, while the session is confirmed: a token that the other end
    /// gave out, for what it is to take only soon after ([`Link::token_age_us`]).
    pub fn token(&self) -> Option<u64> {
        self.session.as_ref().filter(|session| session.is_confirmed()).and_then(Session::stamp_us)
    }

    /// How long ago this end gave out the token, µs; `None` if that was not in this session.
    pub fn token_age_us(&self, now: u64, token: u64) -> Option<u64> {
        self.session.as_ref().and_then(|session| session.age_us(now, token))
    }

    /// The next datagram that is taken has waited here for so long since it came, µs, and is not as young as its taking says. Only
    /// the times of probes and replies heed it: how old a message may be counts from when it is taken.
    pub fn waited(&mut self, us: u64) {
        self.waited_us = us;
    }

    /// When the datagram that was opened last was sealed, µs of the other end's clock.
    pub fn sealed_us(&self) -> u64 {
        self.sealed_us
    }

    /// The other peer's clock, the round trip and its jitter.
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// What has been counted.
    pub fn counts(&self) -> Counts {
        let (taken, missing) = self.session.as_ref().map_or((0, 0), |session| (session.taken(), session.missing()));
        Counts {
            taken: self.past.taken.saturating_add(taken),
            missing: self.past.missing.saturating_add(missing),
            ..self.past
        }
    }

    /// Fills in what the link knows of a telemetry message; the rest stays as it is.
    pub fn describe(&self, now: u64, telemetry: &mut Telemetry) {
        let counts = self.counts();
        telemetry.stage = self.stage() as u8;
        telemetry.round_trip_us = self.clock.round_trip_us().unwrap_or(0);
        telemetry.jitter_us = self.clock.jitter_us();
        telemetry.clock_offset_us = self.clock.offset_us(now).unwrap_or(0);
        telemetry.clock_drift_ppm = self.clock.drift_ppm();
        telemetry.packets_taken = counts.taken;
        telemetry.packets_missing = counts.missing;
        telemetry.flow_late = counts.late;
        telemetry.refused = counts.refused;
    }

    fn after(&self, from: u64, periods: u32) -> u64 {
        from.saturating_add(u64::from(self.period_us).saturating_mul(u64::from(periods)))
    }

    /// The time after so many of the longest silences of flow, µs.
    fn paced(&self, from: u64, silences: u32) -> u64 {
        from.saturating_add(u64::from(self.pace_us).saturating_mul(u64::from(silences)))
    }

    /// How long a message counts, and a session that nothing was answered in, µs.
    fn life_us(&self) -> u64 {
        self.handshake.life_us.max(self.after(0, DISENGAGE_AFTER))
    }

    fn advance(&mut self, now: u64) {
        self.engagement.update(now);
        let over = self.session.as_ref().is_some_and(|session| match session.is_confirmed() {
            true => now >= self.heard_us.saturating_add(self.engagement.disengage_after_us()),
            false => now >= session.began_us.saturating_add(self.life_us()),
        });
        if over {
            if self.session.as_ref().is_some_and(|session| !session.is_confirmed()) {
                // The next session has other keys and another number, whatever it was that kept this one from being confirmed.
                self.handshake.renew();
            }
            self.end();
            self.next_hello_us = now;
        }
        self.settle();
    }

    fn seal(&mut self, now: u64, message: &Message, out: &mut Datagram) -> Option<usize> {
        let len = self.session.as_mut()?.seal(&mut self.counter, now, self.says, message, out).ok()?;
        self.sent_us = now;
        Some(len)
    }
}

// A link on a microcontroller: everything it will ever need, at once.
const _: () = assert!(size_of::<Link>() <= 4096 && Greeting::TAGGED == size_of::<Datagram>());

#[cfg(test)]
#[path = "../tests/inside/search/mod.rs"]
mod search;
