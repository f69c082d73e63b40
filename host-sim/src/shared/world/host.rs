//! Host: a server of a static world, without a socket. A datagram comes in, the answers go out before it returns.
//!
//! Every client has a line with its own key (`haptic_protocol::key::Key::line`). A greeting names its line, a sealed datagram
//! its session; addresses prove nothing, so a client is answered where it last proved itself from. A link is made when a line
//! is first called, so memory grows with the clients that there are, up to the lines that were allowed.
//!
//! **Cost** of a datagram: one lookup, one opening, and one sealing for each answer; it does not grow with the number of
//! clients. Once a packet period all links are looked at, for what time alone makes due.

use std::collections::HashMap;

use haptic_protocol::key::Key;
use haptic_protocol::link::{Link, Stage};
use haptic_protocol::roles::static_scene::{Board, Server};
use haptic_protocol::wire::{Goodbye, Header, MAX_DATAGRAM, Message};
use haptic_sim::node::Says as _;

use super::{CLIENT, OBJECTS, World, line_of, open_link};

/// Most clients of one server.
pub const MOST_LINES: u32 = 4096;
/// A client that is silent for this long is not told to others, µs.
const PRESENT_US: u64 = 1_000_000;

/// One client's end.
struct Line<A> {
    link: Link,
    /// Where it last proved itself from.
    address: Option<A>,
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
    /// Places of clients.
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
    /// What it has done.
    pub counts: Counts,
}

impl<A: Copy> Host<A> {
    /// Server `number` of `world`, the whole or one region of it, for clients on lines 1 to `lines`.
    pub fn new(
        key: Key,
        number: u8,
        lines: u32,
        world: World,
        region: Option<u8>,
        entropy: impl FnMut() -> [u8; Key::LEN] + Send + 'static,
    ) -> Result<Self, String> {
        if !(1..=MOST_LINES).contains(&lines) {
            return Err(format!("lines = {lines} is not allowed: it must be from 1 to {MOST_LINES}"));
        }
        Ok(Self {
            key,
            number,
            entropy: Box::new(entropy),
            lines: std::iter::repeat_with(|| None).take(lines as usize).collect(),
            sessions: HashMap::new(),
            server: Box::new(Server::new(world, region).map_err(|error| error.to_string())?),
            board: Box::new(Board::new(PRESENT_US)),
            counts: Counts::default(),
        })
    }

    /// Replaces the world; clients notice with the next part they get.
    pub fn publish(&mut self, world: World) -> Result<(), String> {
        self.server.publish(world).map_err(|error| error.to_string())
    }

    /// Clients with a session.
    pub fn clients(&self) -> usize {
        self.sessions.len()
    }

    /// The link of a line; made when it is first called.
    fn open(&mut self, line: u32) -> Option<()> {
        let place = self.lines.get_mut((line as usize).checked_sub(1)?)?;
        if place.is_none() {
            let link = open_link(self.key.line(line), [self.number, CLIENT], (self.entropy)()).ok()?.on_line(line);
            *place = Some(Box::new(Line { link, address: None, session: None, seat: None }));
        }
        Some(())
    }

    /// Takes a datagram that came from `from`, opened in place, and sends every answer. Gives the line it was about.
    pub fn receive(&mut self, now: u64, from: A, datagram: &mut [u8], mut send: impl FnMut(A, &[u8])) -> Option<u32> {
        self.counts.received += 1;
        let sealed = datagram.get(1) == Some(&Header::KIND);
        let number = line_of(datagram, |session| self.sessions.get(&session).copied());
        let Some(number) = number.filter(|number| self.open(*number).is_some()) else {
            self.counts.refused += 1;
            return None;
        };
        let line = self.lines[number as usize - 1].as_deref_mut()?;
        let Ok(incoming) = line.link.receive(now, datagram) else {
            self.counts.refused += 1;
            return None;
        };
        if sealed {
            line.address = Some(from);
        }
        let sent = &mut self.counts.sent;
        let mut answer = |bytes: &[u8]| {
            *sent += 1;
            send(from, bytes);
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
                if let Some((told, seat)) = self.board.hear(now, number, &said, line.seat) {
                    line.seat = Some(seat);
                    line.link.say(now, told, &mut answer);
                }
            }
            _ => {}
        }
        line.link.say_due(now, answer);
        Self::settle(&mut self.sessions, line, number);
        Some(number)
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
        for line in self.lines.iter_mut().flatten() {
            if let Some(address) = line.address {
                line.link.say(now, Goodbye {}, |bytes| send(address, bytes));
            }
        }
    }

    /// What time alone makes due; to be called once a packet period.
    pub fn tick(&mut self, now: u64, mut send: impl FnMut(A, &[u8])) {
        let mut out = [0; MAX_DATAGRAM];
        for (line, number) in self.lines.iter_mut().zip(1..) {
            let Some(line) = line else { continue };
            // A line that nobody proved to be on is not called: a server waits.
            let Some(address) = line.address else { continue };
            while let Some(len) = line.link.poll(now, &mut out) {
                if line.link.stage() == Stage::Calling {
                    line.address = None;
                    break;
                }
                self.counts.sent += 1;
                send(address, &out[..len]);
            }
            Self::settle(&mut self.sessions, line, number);
        }
    }
}

#[cfg(test)]
#[path = "../../../tests/inside/shared_world_host.rs"]
mod tests;
