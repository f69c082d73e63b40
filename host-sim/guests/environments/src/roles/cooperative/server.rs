//! The server's part: it has the engine, or has lent it to one client.

use cohold_protocol::wire::PeerId;

use super::message::{Body, Message};
use crate::roles::collaborative::Lease;
use crate::roles::{Out, Role};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    Here,
    Lent {
        to: PeerId,
        /// When it comes back by itself.
        until_us: u64,
        /// Until when a client that has not heard is notified again.
        announced_until_us: u64,
        /// The client has said that it has it.
        held: bool,
        /// It is asked back; when to say so next.
        recall_us: Option<u64>,
    },
}

/// The server of one object.
#[derive(Clone, Debug)]
pub struct Server {
    lease: Lease,
    version: u32,
    place: Place,
    /// The object as it is moved here, or as its holder last reported it.
    object: Body,
    came: Option<Body>,
}

impl Server {
    /// With the engine, version 1.
    pub fn new(lease: Lease) -> Self {
        Self { lease, version: 1, place: Place::Here, object: Body::default(), came: None }
    }

    /// Whether the object is moved here. Never at the same time as at a client.
    pub fn has_engine(&self) -> bool {
        self.place == Place::Here
    }

    /// Version of the engine, wherever that is.
    pub fn version(&self) -> u32 {
        self.version
    }

    /// The client that the engine is lent to.
    pub fn lent_to(&self) -> Option<PeerId> {
        match self.place {
            Place::Here => None,
            Place::Lent { to, .. } => Some(to),
        }
    }

    /// Asks for the engine back.
    pub fn recall(&mut self, now_us: u64) {
        if let Place::Lent { recall_us, .. } = &mut self.place {
            recall_us.get_or_insert(now_us);
        }
    }

    /// The object as it is moved here; while the engine is lent, nothing.
    pub fn moves(&mut self, body: Body) {
        if self.has_engine() {
            self.object = body;
        }
    }

    /// The holder's flow of states: what the server goes on from if the holder vanishes.
    pub fn take_state(&mut self, from: PeerId, version: u32, body: Body) {
        if version == self.version && self.lent_to() == Some(from) && body.axes.iter().flatten().all(|n| n.is_finite())
        {
            self.object = body;
        }
    }

    /// The engine comes back, with the object as it is now.
    fn back(&mut self, body: Body) {
        self.version = self.version.wrapping_add(1);
        self.place = Place::Here;
        self.object = body;
        self.came = Some(body);
    }
}

/// The notice is that the engine has come back, and from where the object goes on.
impl Role for Server {
    type Message = Message;
    type Notice = Body;

    fn receive(&mut self, now_us: u64, from: PeerId, message: &Message, out: &mut dyn Out<Message>) {
        let until = now_us.saturating_add(self.lease.giver_us());
        match (&mut self.place, *message) {
            (Place::Here, Message::Ask { stamp_us }) => {
                self.version = self.version.wrapping_add(1);
                self.place =
                    Place::Lent { to: from, until_us: until, announced_until_us: until, held: false, recall_us: None };
                out.send(from, Message::Lend { version: self.version, stamp_us, body: self.object });
            }
            // It has not heard: the same again, for the request that it makes now.
            (Place::Lent { to, until_us, announced_until_us, held: false, .. }, Message::Ask { stamp_us })
                if *to == from && now_us < *announced_until_us =>
            {
                *until_us = until;
                out.send(from, Message::Lend { version: self.version, stamp_us, body: self.object });
            }
            (Place::Lent { to, until_us, held, .. }, Message::Renew { version, stamp_us })
                if *to == from && version == self.version =>
            {
                (*until_us, *held) = (until, true);
                out.send(from, Message::Renewed { version, stamp_us });
            }
            (place, Message::Return { version, body }) => {
                // If it is not lent to this one, it was taken, or ran out: either way there is nothing to wait for.
                if matches!(place, Place::Lent { to, .. } if *to == from) && version == self.version {
                    self.back(body);
                }
                out.send(from, Message::Taken { version });
            }
            _ => {}
        }
    }

    fn poll(&mut self, now_us: u64, out: &mut dyn Out<Message>) {
        let Place::Lent { to, until_us, recall_us, .. } = &mut self.place else { return };
        if now_us >= *until_us {
            self.back(self.object);
        } else if let Some(at) = recall_us.as_mut().filter(|at| now_us >= **at) {
            *at = now_us.saturating_add(self.lease.retry_us());
            out.send(*to, Message::Recall { version: self.version });
        }
    }

    fn take_notice(&mut self) -> Option<Body> {
        self.came.take()
    }
}
