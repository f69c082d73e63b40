//! A client's end of a lock: asks, knows how long it may edit, releases.

use cohold_protocol::{notices::Notices, wire::PeerId};

use super::message::{Copy, Message};
use crate::roles::collaborative::lease::Requests;
use crate::roles::collaborative::{Lease, NotOwner, Value};
use crate::roles::{Out, Role};

/// Where a client stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Follows what others do.
    Idle,
    /// Has asked for the right to edit, and waits.
    Asking,
    /// Has the right to edit.
    Owner {
        /// Number of the grant.
        fence: u32,
        /// Until then, on its own clock, µs.
        until_us: u64,
    },
    /// Has finished, and waits for the server's acknowledgement.
    Releasing {
        /// Number of the grant.
        fence: u32,
        /// What the object is now, if it was changed.
        value: Option<Value>,
    },
}

/// What a client has to tell its user.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notice {
    /// The right to edit is granted.
    Granted,
    /// It may no longer: the server was not heard in time. What was edited stays local.
    Expired,
    /// Its edit is published: the official copy of this version.
    Published(u32),
    /// Its edit was released too late: this grant had run out, and somebody else had been granted the object.
    TooLate(u32),
    /// There is a new official copy, this version: the local one is to follow it.
    Changed(u32),
}

/// One user's claim to one object.
#[derive(Clone, Debug)]
pub struct Client {
    server: PeerId,
    lease: Lease,
    incarnation: u32,
    copy: Copy,
    phase: Phase,
    asks: Requests,
    /// Number of the first ask of this claim: answers to earlier ones are answers to something else.
    first: u32,
    /// The highest fence that is over. A release that is still on its way may not meet an owner of the same fence.
    spent: u32,
    next_us: u64,
    notices: Notices<Notice, 8>,
}

impl Client {
    /// A client that follows the object. `incarnation` is never the same at two starts of this peer: a random number.
    pub fn new(server: PeerId, lease: Lease, incarnation: u32, value: Value) -> Self {
        Self {
            server,
            lease,
            incarnation,
            copy: Copy { version: 0, value },
            phase: Phase::Idle,
            asks: Requests::default(),
            first: 1,
            spent: 0,
            next_us: 0,
            notices: Notices::default(),
        }
    }

    /// The official copy as far as it is known here; while this client owns the object, what there was to edit.
    pub fn copy(&self) -> &Copy {
        &self.copy
    }

    /// Where the client stands.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Whether it may edit now.
    pub fn owns(&self, now: u64) -> bool {
        matches!(self.phase, Phase::Owner { until_us, .. } if now < until_us)
    }

    /// The user comes near: it wants to edit. While a release is under way, say it again later.
    pub fn ask(&mut self, now: u64) {
        if self.phase == Phase::Idle {
            self.phase = Phase::Asking;
            self.first = self.asks.newest().saturating_add(1);
            self.next_us = now;
        }
    }

    /// The user moves away without having got it.
    pub fn withdraw(&mut self, out: &mut dyn Out<Message>) {
        if self.phase == Phase::Asking {
            self.phase = Phase::Idle;
            out.send(self.server, Message::Release { fence: 0, value: None });
        }
    }

    /// The user has finished. From now on it does not own the object; `None` if it left it as it was.
    ///
    /// # Errors
    /// This client does not own the object.
    pub fn release(&mut self, now: u64, value: Option<Value>, out: &mut dyn Out<Message>) -> Result<(), NotOwner> {
        let Phase::Owner { fence, until_us } = self.phase else { return Err(NotOwner) };
        if now >= until_us {
            return Err(NotOwner);
        }
        self.phase = Phase::Releasing { fence, value };
        self.spent = self.spent.max(fence);
        self.next_us = now;
        self.poll(now, out);
        Ok(())
    }

    fn granted(&mut self, now: u64, number: u32, fence: u32, copy: Copy, out: &mut dyn Out<Message>) {
        let sent_us = if number >= self.first { self.asks.sent_us(number) } else { None };
        let until_us = sent_us.map(|sent_us| sent_us.saturating_add(self.lease.holder_us()));
        match (self.phase, until_us) {
            // Granted to one who has gone away again.
            (Phase::Idle, _) => {
                self.spent = self.spent.max(fence);
                out.send(self.server, Message::Release { fence, value: None });
            }
            (Phase::Asking, _) if fence <= self.spent => {
                out.send(self.server, Message::Release { fence, value: None });
            }
            (Phase::Asking, Some(until_us)) if now < until_us => {
                self.learn(copy);
                self.phase = Phase::Owner { fence, until_us };
                self.notices.put(Notice::Granted);
            }
            (Phase::Owner { fence: held, until_us: before }, Some(until_us)) if fence == held => {
                self.phase = Phase::Owner { fence, until_us: before.max(until_us) };
            }
            _ => {}
        }
    }

    fn answered(&mut self, answered: u32, taken: bool) {
        let Phase::Releasing { fence, value } = self.phase else { return };
        if fence != answered {
            return;
        }
        self.phase = Phase::Idle;
        match value {
            Some(value) if taken => {
                if fence > self.copy.version {
                    self.copy = Copy { version: fence, value };
                }
                self.notices.put(Notice::Published(fence));
            }
            Some(_) => self.notices.put(Notice::TooLate(fence)),
            None => {}
        }
    }

    fn learn(&mut self, copy: Copy) {
        if copy.version > self.copy.version {
            self.copy = copy;
            self.notices.put(Notice::Changed(copy.version));
        }
    }

    fn expire(&mut self, now: u64) {
        if let Phase::Owner { fence, until_us } = self.phase
            && now >= until_us
        {
            self.phase = Phase::Idle;
            self.spent = self.spent.max(fence);
            self.notices.put(Notice::Expired);
        }
    }
}

impl Role for Client {
    type Message = Message;
    type Notice = Notice;

    fn receive(&mut self, now: u64, from: PeerId, message: &Message, out: &mut dyn Out<Message>) {
        self.expire(now);
        if from != self.server {
            return;
        }
        match *message {
            Message::Grant { incarnation, number, fence, copy } if incarnation == self.incarnation => {
                self.granted(now, number, fence, copy, out);
            }
            Message::State { copy } => self.learn(copy),
            Message::Answer { fence, taken } => self.answered(fence, taken),
            // Meant for an earlier life of this client; or what a client says.
            _ => {}
        }
    }

    fn poll(&mut self, now: u64, out: &mut dyn Out<Message>) {
        self.expire(now);
        if now < self.next_us {
            return;
        }
        let every = if self.phase == Phase::Idle { self.lease.giver_us() / 2 } else { self.lease.retry_us() };
        self.next_us = now.saturating_add(every);
        let known = self.copy.version;
        let message = match self.phase {
            Phase::Idle => Message::Follow { known },
            Phase::Asking | Phase::Owner { .. } => {
                Message::Ask { incarnation: self.incarnation, number: self.asks.send(now), known }
            }
            Phase::Releasing { fence, value } => Message::Release { fence, value },
        };
        out.send(self.server, message);
    }

    fn take_notice(&mut self) -> Option<Notice> {
        self.notices.take()
    }
}
