//! The server's part: it has the engine, or has lent it to one client.

use super::{Body, Lease, Message};
use crate::wire::PeerId;

/// Where the engine is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    Here,
    Lent {
        to: PeerId,
        /// When it comes back by itself.
        until_us: u64,
        /// Until when a client that has not heard is told again.
        told_until_us: u64,
        /// The client has said that it has it.
        held: bool,
        /// It is asked back; when to say so next.
        recall_us: Option<u64>,
    },
}

/// What the server has to do about a message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heard {
    /// Say this to the client that the message was from.
    pub say: Option<Message>,
    /// The engine has come back: go on from here.
    pub came: Option<Body>,
}

const NOTHING: Heard = Heard { say: None, came: None };

/// The server of one object.
#[derive(Clone, Debug)]
pub struct Server {
    lease: Lease,
    version: u32,
    place: Place,
    /// The last motion that the holder told.
    told: Body,
}

impl Server {
    /// With the engine, version 1.
    pub fn new(lease: Lease) -> Self {
        Self { lease, version: 1, place: Place::Here, told: Body::default() }
    }

    /// Whether the object is moved here. Never at the same time as at a client.
    pub fn has_engine(&self) -> bool {
        self.place == Place::Here
    }

    /// Of the engine, wherever it is.
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

    /// The holder's flow of states: what the server goes on from if the holder vanishes.
    pub fn told(&mut self, from: PeerId, version: u32, body: Body) {
        if version == self.version && self.lent_to() == Some(from) && body.axes.iter().flatten().all(|n| n.is_finite())
        {
            self.told = body;
        }
    }

    /// Takes in a message; `body` is the object now, for the case that the engine leaves.
    pub fn receive(&mut self, now_us: u64, from: PeerId, message: &Message, body: Body) -> Heard {
        let until = now_us.saturating_add(self.lease.giver_us());
        match (&mut self.place, *message) {
            (Place::Here, Message::Ask { stamp_us }) => {
                self.version = self.version.wrapping_add(1);
                self.told = body;
                self.place =
                    Place::Lent { to: from, until_us: until, told_until_us: until, held: false, recall_us: None };
                Heard { say: Some(Message::Lend { version: self.version, stamp_us, body }), came: None }
            }
            // It has not heard: the same again, for the request that it makes now.
            (Place::Lent { to, until_us, told_until_us, held: false, .. }, Message::Ask { stamp_us })
                if *to == from && now_us < *told_until_us =>
            {
                *until_us = until;
                Heard { say: Some(Message::Lend { version: self.version, stamp_us, body: self.told }), came: None }
            }
            (Place::Lent { to, until_us, held, .. }, Message::Renew { version, stamp_us })
                if *to == from && version == self.version =>
            {
                (*until_us, *held) = (until, true);
                Heard { say: Some(Message::Renewed { version, stamp_us }), came: None }
            }
            (Place::Lent { to, .. }, Message::Return { version, body }) if *to == from && version == self.version => {
                self.back();
                Heard { say: Some(Message::Taken { version }), came: Some(body) }
            }
            // It was taken, or ran out: either way there is nothing to wait for.
            (_, Message::Return { version, .. }) => Heard { say: Some(Message::Taken { version }), came: None },
            _ => NOTHING,
        }
    }

    fn back(&mut self) {
        self.version = self.version.wrapping_add(1);
        self.place = Place::Here;
    }

    /// Lets time pass: what to say to whom, and where the object goes on from if the engine has come back by itself.
    pub fn poll(&mut self, now_us: u64) -> (Option<(PeerId, Message)>, Option<Body>) {
        let Place::Lent { to, until_us, recall_us, .. } = &mut self.place else { return (None, None) };
        if now_us >= *until_us {
            self.back();
            return (None, Some(self.told));
        }
        match recall_us {
            Some(at) if now_us >= *at => {
                *at = now_us.saturating_add(self.lease.retry_us());
                (Some((*to, Message::Recall { version: self.version })), None)
            }
            _ => (None, None),
        }
    }
}
