//! Path: where an end that waits to be called (a hub, a server, a board's operator's port) answers, and how an address proves itself.
//!
//! Anybody can write any address on a datagram, and what was copied on its way can come from elsewhere first. So
//!
//! - a session is answered at the address that its newest datagram came from, until one has proved itself: a probe was sent
//!   there, and its answer came from there. From then on it stays with that one, until nothing has come from there for 6 packet
//!   periods of at least 8 ms ([`Link::quiet_us`]) or the session ends;
//! - before that, an address is sent no more bytes than came from it.
//!
//! Who has moved, or was given another address on the way, falls silent at the old one and is answered at the new one after that, and
//! so within 12 packet periods, in the same session. What comes from an address keeps it though it was taken before: whoever only
//! copies or injects datagrams moves nothing, however early his copies come; who can carry both ways, probes and answers, and drop, is
//! the network, and can do what a network can.

use crate::link::Link;
use crate::wire::{Greeting, GreetingKind, Header};

/// The addresses of one line.
#[derive(Clone, Copy, Debug)]
pub struct Path<A> {
    session: Option<u32>,
    end: Option<Place<A>>,
}

#[derive(Clone, Copy, Debug)]
struct Place<A> {
    address: A,
    /// From when on whatever the line said in this session went there, µs.
    from_us: u64,
    /// When something of this session came from there last, µs.
    seen_us: u64,
    proved: bool,
    /// Bytes that may go there yet.
    room: usize,
}

impl<A> Default for Path<A> {
    fn default() -> Self {
        Self { session: None, end: None }
    }
}

impl<A: Copy + PartialEq> Path<A> {
    /// Takes note of a datagram that came from there, once the line's link has taken or refused it: a greeting, which only tells where a
    /// session begins, or a sealed one. Of what was refused it counts that something which names the session came from there.
    pub fn heard(&mut self, now_us: u64, from: A, datagram: &mut [u8], taken: bool, link: &Link) {
        let (bytes, session) = (datagram.len(), link.session_number());
        let greeting = datagram.get(1).is_some_and(|kind| Greeting::is_kind(*kind));
        let names = |session| Header::parse(datagram).is_ok_and(|(header, ..)| header.session == session);
        if let Some(end) = self.end.as_mut().filter(|end| end.address == from)
            && session.is_some_and(names)
        {
            end.seen_us = now_us;
        }
        if !taken {
            return;
        }
        let begins = session != self.session;
        if begins {
            (self.session, self.end) = (session, None);
        }
        if session.is_none() || greeting && !begins {
            return;
        }
        let answered_us = link.answered_us();
        match &mut self.end {
            Some(end) if end.address == from => {
                end.room = end.room.saturating_add(bytes);
                end.proved |= answered_us.is_some_and(|us| us >= end.from_us);
            }
            Some(end) if end.proved && now_us < end.seen_us.saturating_add(link.quiet_us()) => {}
            end => {
                let from_us = if begins { 0 } else { now_us + 1 };
                *end = Some(Place { address: from, from_us, seen_us: now_us, proved: false, room: bytes });
            }
        }
    }

    /// Where a datagram of the line's link goes, which is then on its way: a welcome to whoever it answers, for the greeting may
    /// be an old one, sent again by anybody; a hello to nobody, for hubs and servers wait and their clients call; all else where
    /// the line is answered, and nowhere while that address has not earned it.
    pub fn of(&mut self, datagram: &[u8], answers: Option<A>) -> Option<A> {
        match datagram.get(1) {
            Some(kind) if *kind == GreetingKind::Welcome as u8 => answers,
            Some(kind) if *kind == GreetingKind::Hello as u8 => None,
            _ => self.to(datagram.len()),
        }
    }

    fn to(&mut self, bytes: usize) -> Option<A> {
        let end = self.end.as_mut()?;
        if !end.proved {
            end.room = end.room.checked_sub(bytes)?;
        }
        Some(end.address)
    }

    /// Where it is answered.
    pub fn address(&self) -> Option<A> {
        self.end.map(|end| end.address)
    }
}
