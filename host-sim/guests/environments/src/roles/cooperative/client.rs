//! A client's part: it has the engine while a lease from the server runs.

use cohold_protocol::{notices::Notices, wire::PeerId};

use super::message::{Body, Message};
use crate::roles::collaborative::Lease;
use crate::roles::{Out, Role};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    Away,
    Asked {
        /// The first request, µs.
        since_us: u64,
        say_us: u64,
    },
    Here {
        version: u32,
        until_us: u64,
        say_us: u64,
    },
    /// On its way back.
    Returned {
        version: u32,
        body: Body,
        until_us: u64,
        say_us: u64,
    },
}

/// What a client has to tell its user.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Notice {
    /// The engine is here: go on from this.
    Came(Body),
    /// The server wants it back: [`Client::give_back`] when it suits.
    Recalled,
}

/// One client of one object.
#[derive(Clone, Debug)]
pub struct Client {
    server: PeerId,
    lease: Lease,
    place: Place,
    /// The newest engine that was ever here.
    newest: u32,
    notices: Notices<Notice, 4>,
}

impl Client {
    /// Without the engine; the lease must be the server's.
    pub fn new(server: PeerId, lease: Lease) -> Self {
        Self { server, lease, place: Place::Away, newest: 0, notices: Notices::default() }
    }

    /// Asks for the engine.
    pub fn ask(&mut self, now_us: u64) {
        if self.place == Place::Away {
            self.place = Place::Asked { since_us: now_us, say_us: now_us };
        }
    }

    /// The version under which the object is moved here now, if it is. Ask before every step: the right may have run out.
    pub fn engine(&self, now_us: u64) -> Option<u32> {
        match self.place {
            Place::Here { version, until_us, .. } if now_us < until_us => Some(version),
            _ => None,
        }
    }

    /// Lets go of the engine, with the object as it is now. It may not be moved here any more from this instant.
    pub fn give_back(&mut self, now_us: u64, body: Body) {
        match self.place {
            Place::Here { version, until_us, .. } if now_us < until_us => {
                self.place = Place::Returned { version, body, until_us, say_us: now_us };
            }
            Place::Asked { .. } => self.place = Place::Away,
            _ => {}
        }
    }
}

impl Role for Client {
    type Message = Message;
    type Notice = Notice;

    fn receive(&mut self, now_us: u64, from: PeerId, message: &Message, _: &mut dyn Out<Message>) {
        if from != self.server {
            return;
        }
        let holder_us = self.lease.holder_us();
        match (&mut self.place, *message) {
            (Place::Asked { since_us, .. }, Message::Lend { version, stamp_us, body }) => {
                let until_us = stamp_us.saturating_add(holder_us);
                let ours = stamp_us >= *since_us && stamp_us <= now_us && version > self.newest;
                if ours && now_us < until_us {
                    self.newest = version;
                    self.place = Place::Here { version, until_us, say_us: now_us };
                    self.notices.put(Notice::Came(body));
                }
            }
            // An old request, or one that it thought better of: back at once.
            (Place::Away | Place::Returned { .. }, Message::Lend { version, stamp_us, body })
                if version > self.newest =>
            {
                self.newest = version;
                let until_us = stamp_us.saturating_add(holder_us);
                self.place = Place::Returned { version, body, until_us, say_us: now_us };
            }
            (Place::Here { version, until_us, .. }, Message::Renewed { version: of, stamp_us })
                if *version == of && stamp_us <= now_us && now_us < *until_us =>
            {
                *until_us = (*until_us).max(stamp_us.saturating_add(holder_us));
            }
            (Place::Here { version, .. }, Message::Recall { version: of }) if *version == of => {
                self.notices.put(Notice::Recalled);
            }
            (Place::Returned { version, .. }, Message::Taken { version: of }) if *version == of => {
                self.place = Place::Away;
            }
            _ => {}
        }
    }

    fn poll(&mut self, now_us: u64, out: &mut dyn Out<Message>) {
        if let Place::Here { until_us, .. } | Place::Returned { until_us, .. } = self.place
            && now_us >= until_us
        {
            self.place = Place::Away;
        }
        let (say_us, message) = match &mut self.place {
            Place::Away => return,
            Place::Asked { say_us, .. } => (say_us, Message::Ask { stamp_us: now_us }),
            Place::Here { version, say_us, .. } => (say_us, Message::Renew { version: *version, stamp_us: now_us }),
            Place::Returned { version, body, say_us, .. } => {
                (say_us, Message::Return { version: *version, body: *body })
            }
        };
        if now_us >= *say_us {
            *say_us = now_us.saturating_add(self.lease.retry_us());
            out.send(self.server, message);
        }
    }

    fn take_notice(&mut self) -> Option<Notice> {
        self.notices.take()
    }
}
