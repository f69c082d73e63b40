//! A client's part: it has the engine while a lease from the server runs.

use super::{Body, Lease, Message};

/// Where the engine is, for this client.
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

/// What a message means to the client.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Told {
    /// Nothing to do.
    Nothing,
    /// The engine is here: go on from this.
    Came(Body),
    /// The server wants it back: [`Client::give_back`] when it suits.
    Recalled,
}

/// One client of one object.
#[derive(Clone, Debug)]
pub struct Client {
    lease: Lease,
    place: Place,
    /// The newest engine that was ever here.
    newest: u32,
}

impl Client {
    /// Without the engine; the lease must be the server's.
    pub fn new(lease: Lease) -> Self {
        Self { lease, place: Place::Away, newest: 0 }
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

    /// Takes in a message of the server.
    pub fn receive(&mut self, now_us: u64, message: &Message) -> Told {
        let holder_us = self.lease.holder_us();
        match (&mut self.place, *message) {
            (Place::Asked { since_us, .. }, Message::Lend { version, stamp_us, body }) => {
                let until_us = stamp_us.saturating_add(holder_us);
                let ours = stamp_us >= *since_us && stamp_us <= now_us && version > self.newest;
                if !ours || now_us >= until_us {
                    return Told::Nothing;
                }
                self.newest = version;
                self.place = Place::Here { version, until_us, say_us: now_us };
                Told::Came(body)
            }
            // An old request, or one that it thought better of: back at once.
            (Place::Away | Place::Returned { .. }, Message::Lend { version, stamp_us, body })
                if version > self.newest =>
            {
                self.newest = version;
                let until_us = stamp_us.saturating_add(holder_us);
                self.place = Place::Returned { version, body, until_us, say_us: now_us };
                Told::Nothing
            }
            (Place::Here { version, until_us, .. }, Message::Renewed { version: of, stamp_us })
                if *version == of && stamp_us <= now_us && now_us < *until_us =>
            {
                *until_us = (*until_us).max(stamp_us.saturating_add(holder_us));
                Told::Nothing
            }
            (Place::Here { version, .. }, Message::Recall { version: of }) if *version == of => Told::Recalled,
            (Place::Returned { version, .. }, Message::Taken { version: of }) if *version == of => {
                self.place = Place::Away;
                Told::Nothing
            }
            _ => Told::Nothing,
        }
    }

    /// Lets time pass: what to say to the server.
    pub fn poll(&mut self, now_us: u64) -> Option<Message> {
        if let Place::Here { until_us, .. } | Place::Returned { until_us, .. } = self.place
            && now_us >= until_us
        {
            self.place = Place::Away;
        }
        let next_us = now_us.saturating_add(self.lease.retry_us());
        match &mut self.place {
            Place::Asked { say_us, .. } if now_us >= *say_us => {
                *say_us = next_us;
                Some(Message::Ask { stamp_us: now_us })
            }
            Place::Here { version, say_us, .. } if now_us >= *say_us => {
                *say_us = next_us;
                Some(Message::Renew { version: *version, stamp_us: now_us })
            }
            Place::Returned { version, body, say_us, .. } if now_us >= *say_us => {
                *say_us = next_us;
                Some(Message::Return { version: *version, body: *body })
            }
            _ => None,
        }
    }
}
