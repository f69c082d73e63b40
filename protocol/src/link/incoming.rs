//! Incoming: what a link does with a datagram, and how that takes it from stage to stage, with a notice of every change.

use super::{Error, Link, Notice, Stage};
use crate::reliable::{Receiver, Sender};
use crate::wire::{Goodbye, Greeting, GreetingKind, Header, Message, Probe};
use crate::{clock::Clock, engagement::Rung, session::Session};

impl Link {
    /// Takes a datagram, which is opened in place, and gives the message in it. `Ok(None)`: it was the link's own business, flow
    /// that came late or is too old, or an event, which waits in [`Link::take_event`].
    ///
    /// No message is given that is older than a second, or 12 packet periods if that is longer; no flow older than
    /// [`Link::within`] says; none at all before the other end has answered in this session.
    ///
    /// An error is no reason to do anything: the datagram was not taken, nothing has changed but [`super::Counts::refused`];
    /// where it was authentic ([`Error::Wire`] from within the seal), also that the other peer was heard; where it is too old
    /// ([`Error::Old`]), that a probe in it will be answered. It says what was
    /// wrong, for a person who wonders why two peers do not meet.
    ///
    /// # Errors
    /// The datagram was refused, and why.
    pub fn receive(&mut self, now: u64, datagram: &mut [u8]) -> Result<Option<Message>, Error> {
        self.advance(now);
        let taken = match datagram.get(1) {
            Some(kind) if Greeting::is_kind(*kind) => self.greeted(now, datagram).map(|()| None),
            _ => self.open(now, datagram),
        };
        if taken.is_err() {
            self.past.refused = self.past.refused.saturating_add(1);
        }
        self.waited_us = 0;
        self.settle();
        taken
    }

    /// A greeting, by the three rules of [`crate::handshake`].
    pub(super) fn greeted(&mut self, now: u64, datagram: &[u8]) -> Result<(), Error> {
        let greeting = self.handshake.open(datagram)?;
        let fresh = self.handshake.is_fresh(now, &greeting);
        if let Some(session) = self.session.as_ref().filter(|session| session.is_named_by(&greeting)) {
            if fresh {
                // The newest challenge is good for longest.
                self.far = greeting.challenge;
            }
            if fresh || session.is_confirmed() {
                return Ok(());
            }
        }
        if !fresh {
            if greeting.kind != GreetingKind::Hello {
                return Err(Error::Stale);
            }
            self.answer = Some(greeting.challenge);
            return Ok(());
        }
        let accepted = self.handshake.accept(now, &greeting).map(|session| {
            self.begin(session, now);
            self.far = greeting.challenge;
        });
        if let Err(Error::Parameters(table)) = accepted {
            // The other peer has started anew, and differs: the session with what it was is over.
            self.refused = Some(table);
            self.far = greeting.challenge;
            self.end();
            self.handshake.forget();
        }
        accepted
    }

    pub(super) fn open(&mut self, now: u64, datagram: &mut [u8]) -> Result<Option<Message>, Error> {
        let (header, head, sealed) = Header::parse(datagram)?;
        self.ends.check(header.from, header.to)?;
        let life_us = self.life_us();
        let session = self.session.as_mut().ok_or(Error::NoSession)?;
        let opened = session.open(now, &header, head, sealed)?;
        let message = Message::parse(opened.message);
        self.sealed_us = opened.sealed_us;
        let came = now.saturating_sub(self.waited_us);
        let Some(age_us) = opened.age_us.filter(|age_us| *age_us < life_us) else {
            // It may be of any time, so it is not there: but for what asks for a time of now, and for what only ends something.
            match message? {
                Message::Probe(Probe { sent_us }) => self.probed = Some((sent_us, came)),
                Message::Goodbye(Goodbye {}) => self.end(),
                _ => {}
            }
            return opened.age_us.map_or(Ok(None), |age_us| Err(Error::Old(age_us)));
        };
        if !session.is_confirmed() {
            session.confirm();
            let incarnation = session.remote.incarnation;
            self.confirm(now, incarnation);
        }
        self.heard_us = now;
        Ok(self.take(now, header.sequence, age_us, message?))
    }

    /// The other end has the keys: the challenge has done its work.
    pub(super) fn confirm(&mut self, now: u64, incarnation: u64) {
        self.handshake.renew();
        self.next_probe_us = now;
        if self.peer != Some(incarnation) {
            // What waits for the first peer ever waits on; what was meant for one that is gone does not.
            let dropped = if self.peer.is_some() { self.sender.under_way() } else { 0 };
            if self.peer.is_some() {
                self.sender = Sender::default();
            }
            self.receiver = Receiver::default();
            self.clock = Clock::default();
            self.peer = Some(incarnation);
            self.notices.put(Notice::NewPeer(u8::try_from(dropped).unwrap_or(u8::MAX)));
        }
        self.sender.hurry();
    }

    /// What the link itself needs it keeps; the rest is the caller's.
    pub(super) fn take(&mut self, now: u64, sequence: u64, age_us: u64, message: Message) -> Option<Message> {
        match message {
            Message::Flow(_) | Message::Flow2(_) | Message::Flow3(_) => {
                if self.newest_flow.is_some_and(|newest| sequence < newest) {
                    self.past.late = self.past.late.saturating_add(1);
                    return None;
                }
                self.newest_flow = Some(sequence);
                // There and back: half of it is one way.
                let delay_us = u32::try_from(age_us / 2).unwrap_or(u32::MAX);
                self.delay_us = Some(delay_us);
                if delay_us > self.max_delay_us {
                    self.past.old = self.past.old.saturating_add(1);
                    if !core::mem::replace(&mut self.is_old, true) {
                        self.notices.put(Notice::Old(delay_us));
                    }
                    return None;
                }
                self.is_old = false;
                self.engagement.hear(now);
                return Some(message);
            }
            Message::Event(event) => {
                self.receiver.receive(event);
                self.ack_due = true;
            }
            Message::Ack(ack) => self.sender.acknowledge(&ack),
            Message::Goodbye(_) => self.end(),
            Message::Probe(Probe { sent_us }) => self.probed = Some((sent_us, now.saturating_sub(self.waited_us))),
            Message::Reply(reply) => {
                self.answered_us = self.answered_us.max(Some(reply.probe_sent_us));
                // A reply with impossible times says nothing; the sender's clock may have been set.
                let came = now.saturating_sub(self.waited_us);
                let _ = self.clock.sample(reply.probe_sent_us, reply.probe_received_us, reply.sent_us, came);
            }
            _ => return Some(message),
        }
        None
    }

    /// How far the two peers have come with each other, as of the last call.
    pub fn stage(&self) -> Stage {
        match (&self.session, self.engagement.rung()) {
            (None, _) if self.refused.is_some() => Stage::Refused,
            (None, _) => Stage::Calling,
            (Some(session), _) if !session.is_confirmed() => Stage::Joining,
            (Some(_), Rung::Disengaged) => Stage::Idle,
            (Some(_), Rung::Engaged) => Stage::Running,
            (Some(_), Rung::Fading) => Stage::Fading,
        }
    }

    /// Whether the other peer is there and holds the key.
    pub fn is_up(&self) -> bool {
        matches!(self.stage(), Stage::Idle | Stage::Running | Stage::Fading)
    }

    /// The table of parameters over which the other peer was refused.
    pub fn refused(&self) -> Option<&'static str> {
        self.refused
    }

    /// The oldest notice that has not been reported.
    pub fn take_notice(&mut self) -> Option<Notice> {
        self.notices.take()
    }

    /// Tells what has changed since the last time.
    pub(super) fn settle(&mut self) {
        let (before, now) = (self.told, self.stage());
        self.told = now;
        let joined = |stage| matches!(stage, Stage::Idle | Stage::Running | Stage::Fading);
        let engaged = |stage| matches!(stage, Stage::Running | Stage::Fading);
        if engaged(before) && !engaged(now) {
            self.notices.put(Notice::Disengaged);
        }
        if joined(before) && !joined(now) {
            self.notices.put(Notice::Lost);
        }
        if joined(now) && !joined(before) {
            self.notices.put(Notice::Joined);
        }
        match (before, now) {
            (Stage::Running, Stage::Fading) => self.notices.put(Notice::Fading),
            (Stage::Fading, Stage::Running) => self.notices.put(Notice::Resumed),
            _ if engaged(now) && !engaged(before) => self.notices.put(Notice::Engaged),
            _ => {}
        }
        if let (Stage::Refused, Some(table)) = (now, self.refused)
            && before != Stage::Refused
        {
            self.notices.put(Notice::Refused(table));
        }
    }

    /// A session begins; it takes the place of any other.
    pub(super) fn begin(&mut self, session: Session, now: u64) {
        self.end();
        self.session = Some(session);
        self.refused = None;
        self.next_hello_us = now;
        self.next_probe_us = now;
    }

    /// The session ends; the engagement with it.
    pub(super) fn end(&mut self) {
        if let Some(session) = self.session.take() {
            self.past.taken = self.past.taken.saturating_add(session.taken());
            self.past.missing = self.past.missing.saturating_add(session.missing());
        }
        self.engagement.part();
        self.newest_flow = None;
        self.delay_us = None;
        self.is_old = false;
        self.probed = None;
        self.answered_us = None;
        self.ack_due = false;
        self.settle();
    }
}
