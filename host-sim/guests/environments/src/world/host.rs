//! Host: a server of a static world, without a socket. A datagram comes in, the answers go out before it returns.
//!
//! Every client has a line with its own key (`cohold_protocol::key::Key::line`). A greeting names its line, a sealed datagram
//! its session; addresses prove nothing, and where a client is answered is its line's path (`path.rs`). A link is kept when
//! a line is first called under its key, so memory grows with the clients that there are, up to the lines that were allowed; for
//! whoever holds no key nothing is allocated. Whoever greets so is answered once a second at the most, with no more bytes, by
//! a greeting from which its link gathers why.
//!
//! **Cost** of a datagram: one lookup, one opening, and one sealing for each answer; it does not grow with the number of
//! clients. Once a packet period all links are looked at, for what time alone makes due.

use std::collections::HashMap;
use std::fmt::Display;

use cohold_live::refused::{Refused, is_telling, wrong};
use cohold_protocol::link::{Error, Link};
use cohold_protocol::wire::{Goodbye, Greeting, MAX_DATAGRAM, Message, PeerId};
use cohold_protocol::{ends::Ends, key::Key};

use super::{CLIENT, OBJECTS, World, line_of, open_link};
use crate::roles::static_scene::{Board, Server};
use cohold_protocol::path::Path;

/// Most clients of one server.
pub const MOST_LINES: u32 = Key::MOST_LINES;
/// A client that is silent for this long is not shown to others, µs.
const PRESENT_US: u64 = 1_000_000;
/// Between two answers to those who hold no line's key, µs.
const ANSWER_EVERY_US: u64 = 1_000_000;

/// The server's end of one client's line.
struct Line<A> {
    link: Link,
    /// Where it is answered.
    path: Path<A>,
    session: Option<u32>,
    seat: Option<usize>,
}

/// What a server has done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Counts {
    pub(crate) received: u64,
    pub(crate) sent: u64,
    /// Datagrams that were of no line or no session, or were refused by their link.
    pub refused: u64,
    pub(crate) asks: u64,
    pub(crate) parts: u64,
    /// Reports of clients' places that were sent.
    pub(crate) presences: u64,
}

/// A server of a static world.
pub struct Host<A> {
    key: Key,
    number: u8,
    entropy: Box<dyn FnMut() -> [u8; Key::LEN] + Send>,
    lines: Vec<Option<Box<Line<A>>>>,
    sessions: HashMap<u32, u32>,
    pub(crate) server: Box<Server<OBJECTS>>,
    board: Box<Board<{ MOST_LINES as usize }>>,
    /// Counts of what the server has done.
    pub counts: Counts,
    refused: Refused<A>,
    next_answer_us: u64,
}

impl<A: Copy + PartialEq> Host<A> {
    /// Server `number` of `world`, the whole or one region of it, for clients on lines 1 to `lines`.
    pub fn new(
        key: Key,
        number: u8,
        lines: u32,
        world: World,
        region: Option<u8>,
        entropy: impl FnMut() -> [u8; Key::LEN] + Send + 'static,
    ) -> Result<Self, crate::Error> {
        if !(1..=MOST_LINES).contains(&lines) {
            let allowed = format!("it must be from 1 to {MOST_LINES}");
            return Err(cohold_sim::Error::not_allowed(format!("lines = {lines}"), allowed).into());
        }
        Ok(Self {
            key,
            number,
            entropy: Box::new(entropy),
            lines: std::iter::repeat_with(|| None).take(lines as usize).collect(),
            sessions: HashMap::new(),
            server: Box::new(Server::new(world, region)?),
            board: Box::new(Board::new(PRESENT_US)),
            counts: Counts::default(),
            refused: Refused::default(),
            next_answer_us: 0,
        })
    }

    /// Replaces the world; clients notice with the next part they get.
    ///
    /// # Errors
    /// A number of the world that cannot be encoded.
    pub fn publish(&mut self, world: World) -> Result<(), crate::Error> {
        Ok(self.server.publish(world)?)
    }

    /// Clients with a session.
    pub fn clients(&self) -> usize {
        self.sessions.len()
    }

    /// Memory that lines take, in links.
    pub fn lines_called(&self) -> usize {
        self.lines.iter().flatten().count()
    }

    fn link(&mut self, key: Key, line: u32) -> Option<Link> {
        Some(open_link(key, [self.number, CLIENT], (self.entropy)()).ok()?.on_line(line))
    }

    /// A line's link takes a datagram; for a line that is called for the first time, under its key, one is made.
    fn take(&mut self, now: u64, number: u32, datagram: &mut [u8]) -> Result<Option<Message>, Error> {
        let at = (number as usize).checked_sub(1).filter(|at| *at < self.lines.len()).ok_or(Error::OtherLine)?;
        if let Some(line) = &mut self.lines[at] {
            return line.link.receive(now, datagram);
        }
        let key = self.key.line(number);
        let ends = Ends { local: PeerId(self.number), remote: PeerId(CLIENT) };
        Link::is_called(&key, ends, number, datagram)?;
        let mut link = self.link(key, number).ok_or(Error::NoSession)?;
        let taken = link.receive(now, datagram)?;
        self.lines[at] = Some(Box::new(Line { link, path: Path::default(), session: None, seat: None }));
        Ok(taken)
    }

    /// Takes a datagram that came from `from`, opened in place, and sends every answer. Gives the line it was about.
    pub fn receive(&mut self, now: u64, from: A, datagram: &mut [u8], mut send: impl FnMut(A, &[u8])) -> Option<u32> {
        self.counts.received += 1;
        let number = line_of(datagram, |session| self.sessions.get(&session).copied());
        let taken = number.and_then(|number| {
            let taken = self.take(now, number, datagram);
            if let Some(line) = self.lines.get_mut((number as usize).wrapping_sub(1)).and_then(Option::as_mut) {
                line.path.heard(now, from, datagram, taken.is_ok(), &line.link);
            }
            Ok((number, taken?))
        });
        let (number, incoming) = match taken {
            Ok(taken) => taken,
            Err(why) => {
                self.refuse(now, from, datagram, why, send);
                return None;
            }
        };
        let line = self.lines[number as usize - 1].as_deref_mut()?;
        let (sent, path) = (&mut self.counts.sent, &mut line.path);
        let mut answer = |bytes: &[u8]| {
            if let Some(to) = path.of(bytes, Some(from)) {
                *sent += 1;
                send(to, bytes);
            }
        };
        match incoming {
            Some(Message::Ask(ask)) => {
                self.counts.asks += 1;
                for part in self.server.answer(&ask) {
                    self.counts.parts += u64::from(line.link.say(now, part, &mut answer));
                }
            }
            Some(Message::Presence(said)) => {
                self.counts.presences += 1;
                if let Some((presence, seat)) = self.board.hear(now, number, &said, line.seat) {
                    line.seat = Some(seat);
                    line.link.say(now, presence, &mut answer);
                }
            }
            _ => {}
        }
        line.link.say_due(now, answer);
        Self::settle(&mut self.sessions, line, number);
        Some(number)
    }

    /// What came is of nobody who holds a line's key: for a person to know, and for whoever called.
    fn refuse(&mut self, now: u64, from: A, datagram: &[u8], why: Error, mut send: impl FnMut(A, &[u8])) {
        self.counts.refused += 1;
        if !is_telling(&why) {
            return;
        }
        self.refused.note(from, why);
        if now < self.next_answer_us {
            return;
        }
        self.next_answer_us = now + ANSWER_EVERY_US;
        let line = Greeting::parse(datagram).map_or(1, |(greeting, ..)| greeting.line);
        let mut out = [0; MAX_DATAGRAM];
        // Under the server's own key, which is no line's.
        if let Some(len) = self.link(self.key.clone(), line).and_then(|mut link| link.poll(now, &mut out))
            && len <= datagram.len()
        {
            self.counts.sent += 1;
            send(from, &out[..len]);
        }
    }

    /// Keeps the list of sessions in step with a link.
    fn settle(sessions: &mut HashMap<u32, u32>, line: &mut Line<A>, number: u32) {
        let session = line.link.session_number();
        if session != line.session {
            if let Some(old) = line.session.take().filter(|old| sessions.get(old) == Some(&number)) {
                sessions.remove(&old);
            }
            if let Some(new) = session {
                // Two lines with one number: the first keeps it. The other one's session dies of silence, and the next has another
                // number; so nobody who looks for such a number can drive anybody else out.
                sessions.entry(new).or_insert(number);
            }
            line.session = session;
        }
    }

    /// Tells all clients that this is the end.
    pub fn goodbye(&mut self, now: u64, mut send: impl FnMut(A, &[u8])) {
        for Line { link, path, .. } in self.lines.iter_mut().flatten().map(Box::as_mut) {
            link.say(now, Goodbye {}, |bytes| _ = path.of(bytes, None).map(|to| send(to, bytes)));
        }
    }

    /// What time alone makes due; to be called once a packet period.
    pub fn tick(&mut self, now: u64, mut send: impl FnMut(A, &[u8])) {
        (0..Self::TURNS).for_each(|turn| self.tick_turn(now, turn, &mut send));
    }

    /// In how many turns a packet period's tick can be taken, so that what comes meanwhile need not wait for all lines.
    pub const TURNS: u32 = 8;

    /// [`Host::tick`] for the lines whose turn it is; to be called with each turn once a packet period.
    pub fn tick_turn(&mut self, now: u64, turn: u32, mut send: impl FnMut(A, &[u8])) {
        let lines = self.lines.iter_mut().zip(1..).skip(turn as usize);
        for (line, number) in lines.step_by(Self::TURNS as usize) {
            let Some(line) = line else { continue };
            let (link, path, sent) = (&mut line.link, &mut line.path, &mut self.counts.sent);
            link.say_due(now, |bytes| {
                if let Some(to) = path.of(bytes, None) {
                    *sent += 1;
                    send(to, bytes);
                }
            });
            Self::settle(&mut self.sessions, line, number);
        }
    }
}

impl<A: Copy + PartialEq + Display> Host<A> {
    /// What there is to tell a person about those who are refused; nothing most of the time, and never much.
    pub fn news(&mut self, now: u64) -> Option<String> {
        self.refused.take(now).map(|(from, why)| wrong(from, &why))
    }

    /// Who was refused last, and why, of what tells something.
    pub(crate) fn refused(&self) -> Option<String> {
        self.refused.newest.map(|(from, why)| wrong(from, &why))
    }
}

#[cfg(test)]
#[path = "../../tests/inside/world_host.rs"]
mod tests;
