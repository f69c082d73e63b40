//! Incoming: what a link does with a datagram, and how that takes it from stage to stage, with a notice of every change.

use super::{Error, Link, Notice, Stage};
use crate::reliable::{Receiver, Sender};
use crate::wire::{Greeting, GreetingKind, Header, Message, Probe};
use crate::{clock::Clock, engagement::Rung, session::Session};

impl Link {
    /// Takes a datagram, which is opened in place, and gives the message in it. `Ok(None)`: it was the link's own business, flow
    /// that came late, or an event, which waits in [`Link::take_event`].
    ///
    /// An error is no reason to do anything: the datagram was not taken, nothing has changed but [`super::Counts::refused`];
    /// where it was authentic ([`Error::Wire`] from within the seal), also that the other peer was heard. It says what was
    /// wrong, for a person who wonders why two peers do not meet.
    pub fn receive(&mut self, now: u64, datagram: &mut [u8]) -> Result<Option<Message>, Error> {
        self.advance(now);
        let taken = match datagram.get(1) {
            Some(kind) if Greeting::is_kind(*kind) => self.greeted(now, datagram).map(|()| None),
            _ => self.open(now, datagram),
        };
        if taken.is_err() {
            self.past.refused = self.past.refused.saturating_add(1);
        }
        self.settle();
        taken
    }

    /// A greeting, by the three rules of [`crate::handshake`].
    fn greeted(&mut self, now: u64, datagram: &[u8]) -> Result<(), Error> {
        let greeting = self.handshake.open(datagram)?;
        if self.session.as_ref().is_some_and(|session| session.is_named_by(&greeting)) {
            return Ok(());
        }
        if !self.handshake.is_fresh(&greeting) {
            if greeting.kind != GreetingKind::Hello {
                return Err(Error::Stale);
            }
            self.answer = Some(greeting.challenge);
            return Ok(());
        }
        let accepted = self.handshake.accept(&greeting).map(|session| self.begin(session, now));
        if let Err(Error::Parameters(table)) = accepted {
            // The other peer has started anew, and differs: the session with what it was is over.
            self.refused = Some(table);
            self.far = greeting.challenge;
            self.end();
            self.handshake.renew();
        }
        accepted
    }

    fn open(&mut self, now: u64, datagram: &mut [u8]) -> Result<Option<Message>, Error> {
        let (header, head, sealed) = Header::parse(datagram)?;
        self.ends.check(header.from, header.to)?;
        let session = self.session.as_mut().ok_or(Error::NoSession)?;
        let first = !session.is_confirmed();
        let message = session.open(&header, head, sealed)?;
        let incarnation = session.remote.incarnation;
        self.heard_us = now;
        if first {
            self.confirm(now, incarnation);
        }
        let message = Message::parse(message)?;
        Ok(self.take(now, header.sequence, message))
    }

    /// The other end has the keys: the challenge has done its work.
    fn confirm(&mut self, now: u64, incarnation: u64) {
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
    fn take(&mut self, now: u64, sequence: u64, message: Message) -> Option<Message> {
        match message {
            Message::Flow(_) => {
                if self.newest_flow.is_some_and(|newest| sequence < newest) {
                    self.past.late = self.past.late.saturating_add(1);
                    return None;
                }
                self.newest_flow = Some(sequence);
                self.engagement.hear(now);
                return Some(message);
            }
            Message::Event(event) => {
                self.receiver.receive(event);
                self.ack_due = true;
            }
            Message::Ack(ack) => self.sender.acknowledge(&ack),
            Message::Goodbye(_) => self.end(),
            Message::Probe(Probe { sent_us }) => self.probed = Some((sent_us, now)),
            Message::Reply(reply) => {
                self.answered_us = self.answered_us.max(Some(reply.probe_sent_us));
                // A reply with impossible times says nothing; the sender's clock may have been set.
                let _ = self.clock.sample(reply.probe_sent_us, reply.probe_received_us, reply.sent_us, now);
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
            (Some(_), Rung::Apart) => Stage::Idle,
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

    /// The oldest notice that has not been told.
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
        self.probed = None;
        self.answered_us = None;
        self.ack_due = false;
        self.settle();
    }
}
