//! The server's end of a lock: queue, grants, the official copy.

use core::convert::Infallible;

use cohold_protocol::wire::PeerId;
use heapless::{Deque, Vec};

use super::message::{Copy, Message};
use crate::roles::collaborative::{Lease, Value};
use crate::roles::{Out, Role};

/// What a server must still know after a crash. Store it before sending what came with the change.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Record<const CLIENTS: usize> {
    /// The official copy of the object.
    pub copy: Copy,
    /// The newest grant's number.
    pub fence: u32,
    /// Who got it, as long as it has not released: an owner that the server has given up, but nobody has followed.
    pub open: Option<PeerId>,
    /// The newest fence under which each client's value was taken.
    pub taken: Vec<(PeerId, u32), CLIENTS>,
}

/// A client that edits or wants to.
#[derive(Clone, Copy, Debug)]
struct Turn {
    client: PeerId,
    incarnation: u32,
    /// Its newest ask.
    number: u32,
    heard_us: u64,
}

/// The server of one object.
#[derive(Clone, Debug)]
pub struct Server<const CLIENTS: usize> {
    lease: Lease,
    record: Record<CLIENTS>,
    closed_until_us: u64,
    holder: Option<Turn>,
    waiting: Deque<Turn, CLIENTS>,
    /// Who is there, and when it was heard last.
    followers: Vec<(PeerId, u64), CLIENTS>,
}

impl<const CLIENTS: usize> Server<CLIENTS> {
    /// A server of an object that nobody has edited.
    pub fn new(lease: Lease, value: Value) -> Self {
        Self::restore(lease, 0, Record { copy: Copy { version: 0, value }, ..Record::default() })
    }

    /// The server of an object as it was recorded. Nothing is granted before one lease is over.
    pub fn restore(lease: Lease, now: u64, record: Record<CLIENTS>) -> Self {
        let closed_until_us = if record.fence == 0 { now } else { now.saturating_add(lease.giver_us()) };
        Self { lease, record, closed_until_us, holder: None, waiting: Deque::new(), followers: Vec::new() }
    }

    /// The record to store before anything is sent.
    pub fn record(&self) -> &Record<CLIENTS> {
        &self.record
    }

    /// The official copy of the object.
    pub fn copy(&self) -> &Copy {
        &self.record.copy
    }

    /// Whom the object is locked for.
    pub fn holder(&self) -> Option<PeerId> {
        self.holder.map(|turn| turn.client)
    }

    /// How many wait for it.
    pub fn waiting(&self) -> usize {
        self.waiting.len()
    }

    /// A client is there, and has this version.
    fn follow(&mut self, now: u64, from: PeerId, known: u32, out: &mut dyn Out<Message>) {
        match self.followers.iter_mut().find(|(client, _)| *client == from) {
            Some((_, heard_us)) => *heard_us = now,
            None => {
                let lease = self.lease.giver_us();
                if self.followers.is_full() {
                    self.followers.retain(|(_, heard_us)| now.saturating_sub(*heard_us) < lease);
                }
                // Full of clients that are there: this one is served as it asks, and not notified by itself.
                let _ = self.followers.push((from, now));
            }
        }
        if known < self.record.copy.version {
            out.send(from, Message::State { copy: self.record.copy });
        }
    }

    fn asked(&mut self, asked: Turn, out: &mut dyn Out<Message>) {
        let same = |turn: &Turn| turn.client == asked.client && turn.incarnation == asked.incarnation;
        if let Some(holder) = self.holder.as_mut().filter(|holder| same(holder)) {
            // A repetition, or an ask that was overtaken, renews nothing.
            if asked.number > holder.number {
                *holder = asked;
                out.send(asked.client, self.granted(&asked));
            }
            return;
        }
        if let Some(waiting) = self.waiting.iter_mut().find(|turn| same(turn)) {
            if asked.number > waiting.number {
                *waiting = asked;
            }
            return;
        }
        // Another life of the same client: the place in the queue was the other one's.
        self.waiting.retain(|turn| turn.client != asked.client);
        // A full queue: it will ask again.
        let _ = self.waiting.push_back(asked);
    }

    fn released(&mut self, from: PeerId, fence: u32, value: Option<Value>, out: &mut dyn Out<Message>) {
        if fence == self.record.fence && self.record.open == Some(from) {
            self.record.open = None;
            self.holder = None;
            if let Some(value) = value {
                self.record.copy = Copy { version: fence, value };
                self.note_taken(from, fence);
                for (client, _) in self.followers.iter().filter(|(client, _)| *client != from) {
                    out.send(*client, Message::State { copy: self.record.copy });
                }
            }
        }
        let taken = self.record.taken.contains(&(from, fence));
        out.send(from, Message::Answer { fence, taken });
    }

    fn note_taken(&mut self, from: PeerId, fence: u32) {
        let taken = &mut self.record.taken;
        taken.retain(|(client, _)| *client != from);
        if taken.is_full()
            && let Some(oldest) = taken.iter().map(|(_, fence)| *fence).min()
        {
            taken.retain(|(_, fence)| *fence != oldest);
        }
        // There is room now.
        let _ = taken.push((from, fence));
    }

    /// Gives up whoever has been silent for a lease.
    fn expire(&mut self, now: u64) {
        let lease = self.lease.giver_us();
        let silent = |turn: &Turn| now.saturating_sub(turn.heard_us) >= lease;
        if self.holder.as_ref().is_some_and(silent) {
            self.holder = None;
        }
        self.waiting.retain(|turn| !silent(turn));
    }

    /// The next in the queue gets it, if it is free.
    fn grant(&mut self, now: u64, out: &mut dyn Out<Message>) {
        if self.holder.is_some() || now < self.closed_until_us {
            return;
        }
        let Some(fence) = self.record.fence.checked_add(1) else { return };
        let Some(next) = self.waiting.pop_front() else { return };
        self.record.fence = fence;
        self.record.open = Some(next.client);
        self.holder = Some(next);
        out.send(next.client, self.granted(&next));
    }

    fn granted(&self, turn: &Turn) -> Message {
        let Turn { incarnation, number, .. } = *turn;
        Message::Grant { incarnation, number, fence: self.record.fence, copy: self.record.copy }
    }
}

impl<const CLIENTS: usize> Role for Server<CLIENTS> {
    type Message = Message;
    type Notice = Infallible;

    fn receive(&mut self, now: u64, from: PeerId, message: &Message, out: &mut dyn Out<Message>) {
        self.expire(now);
        match *message {
            Message::Follow { known } => self.follow(now, from, known, out),
            Message::Ask { incarnation, number, known } => {
                self.follow(now, from, known, out);
                self.asked(Turn { client: from, incarnation, number, heard_us: now }, out);
            }
            Message::Release { fence: 0, .. } => self.waiting.retain(|turn| turn.client != from),
            Message::Release { fence, value } => self.released(from, fence, value, out),
            // What a server says.
            Message::Grant { .. } | Message::State { .. } | Message::Answer { .. } => {}
        }
        self.grant(now, out);
    }

    fn poll(&mut self, now: u64, out: &mut dyn Out<Message>) {
        self.expire(now);
        self.grant(now, out);
    }
}
