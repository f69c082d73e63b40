//! Server and clients of a lock as the world sees them. Peer 0 is the server.

use std::cell::RefCell;
use std::rc::Rc;

use haptic_protocol::roles::collaborative::lock::{self, Client, Message, Notice, Phase, Record, Server};
use haptic_protocol::roles::collaborative::{Lease, Value, Wish};
use haptic_protocol::roles::{self, Carried as _, Role as _};
use haptic_protocol::wire::{self, PeerId};
use haptic_sim::engine::{Actor, Out};
use haptic_sim::rng::Rng;

use super::history::History;
use super::trial::{MOST_USERS, Mistake, Trial};
use super::user::{LONGEST_EDIT_US, User};
use super::world::{Cast, Peer};
use crate::shared::said;

/// The object.
const OBJECT: u16 = 7;
/// Lease of a lock, µs.
const LEASE_US: u32 = 300_000;

const CLIENTS: usize = MOST_USERS as usize;

/// Server or client.
pub enum LockPeer {
    /// The server.
    Server(Box<ServerPeer>),
    /// A client and its user.
    Client(Box<ClientPeer>),
}

/// The server and what it has stored.
pub struct ServerPeer {
    server: Server<CLIENTS>,
    stored: Record<CLIENTS>,
    no_fence: bool,
    history: Rc<RefCell<History>>,
}

/// A client and its user.
pub struct ClientPeer {
    client: Client,
    user: User,
}

fn lease() -> Lease {
    // In range, or nothing here would work at all.
    Lease::new(LEASE_US).unwrap_or_else(|error| panic!("{error}"))
}

/// A server and the trial's users.
pub fn peers(trial: &Trial, history: &Rc<RefCell<History>>) -> Cast<LockPeer> {
    let mut rng = Rng::new(!trial.seed);
    let server = Server::new(lease(), Value::default());
    let (stored, no_fence) = (server.record().clone(), trial.mistake == Some(Mistake::NoFence));
    let server = ServerPeer { server, stored, no_fence, history: Rc::clone(history) };
    let mut peers = vec![LockPeer::Server(Box::new(server))];
    peers.extend((0..trial.users).map(|_| {
        let mut user = User::new(Rng::new(rng.below(u64::MAX)), history);
        LockPeer::Client(Box::new(ClientPeer { client: client(&mut user.rng), user }))
    }));
    let users = u64::from(trial.users);
    Cast {
        peers,
        wait_bound_us: Box::new(move |delay_us| lock::wait_bound_us(lease(), users, LONGEST_EDIT_US, delay_us)),
    }
}

fn client(rng: &mut Rng) -> Client {
    Client::new(PeerId(0), lease(), rng.below(1 << 32) as u32, Value::default())
}

impl ServerPeer {
    fn step(&mut self, now: u64, message: Option<(PeerId, Message)>, out: &mut dyn roles::Out<Message>) {
        match message {
            Some((from, Message::Release { fence, value })) if self.no_fence && fence != 0 => {
                // As if the server did not look who it is from, and under which grant.
                let (holder, fence) = (self.server.holder().unwrap_or(from), self.server.record().fence);
                self.server.receive(now, holder, &Message::Release { fence, value }, out);
            }
            Some((from, message)) => self.server.receive(now, from, &message, out),
            None => self.server.poll(now, out),
        }
        self.stored.clone_from(self.server.record());
        self.history.borrow_mut().official(&self.server.copy().value);
    }
}

impl ClientPeer {
    fn step(&mut self, now: u64, message: Option<(PeerId, Message)>, out: &mut dyn roles::Out<Message>) {
        let Self { client, user } = self;
        match message {
            Some((from, message)) => client.receive(now, from, &message, out),
            None => client.poll(now, out),
        }
        while let Some(notice) = client.take_notice() {
            match notice {
                Notice::Published(version) => user.has_published(version, now),
                Notice::Expired | Notice::TooLate(_) => user.is_interrupted(),
                Notice::Granted | Notice::Changed(_) => {}
            }
        }
        match (user.wish(now), client.phase()) {
            (Wish::Edit, Phase::Idle) => client.ask(now),
            (Wish::Leave, Phase::Asking) => {
                client.withdraw(out);
                user.plan(now);
            }
            (_, Phase::Owner { .. }) if client.owns(now) => {
                if let Some(value) = user.edits(now, &client.copy().value) {
                    user.must(client.release(now, Some(value), out));
                }
            }
            (Wish::Leave, Phase::Idle) if user.is_gone(now) => user.plan(now),
            _ => {}
        }
    }
}

impl LockPeer {
    fn step(&mut self, now_ns: u64, message: Option<(PeerId, Message)>, out: &mut Out<'_, usize, wire::Message>) {
        let (now, out) = (now_ns / 1_000, &mut said(OBJECT, out));
        match self {
            Self::Server(peer) => peer.step(now, message, out),
            Self::Client(peer) => peer.step(now, message, out),
        }
    }
}

impl Actor<usize> for LockPeer {
    type Packet = wire::Message;

    fn hear(&mut self, now_ns: u64, from: usize, message: &mut wire::Message, out: &mut Out<'_, usize, wire::Message>) {
        if let Some((OBJECT, message)) = Message::read(message) {
            self.step(now_ns, Some((PeerId(from as u8), message)), out);
        }
    }

    fn speak(&mut self, now_ns: u64, out: &mut Out<'_, usize, wire::Message>) {
        self.step(now_ns, None, out);
    }
}

impl Peer for LockPeer {
    fn owns(&self, now: u64) -> bool {
        matches!(self, Self::Client(peer) if peer.client.owns(now))
    }

    fn restart(&mut self, now: u64, forgets: bool) {
        match self {
            Self::Server(peer) => {
                let record = if forgets {
                    Server::<CLIENTS>::new(lease(), Value::default()).record().clone()
                } else {
                    peer.stored.clone()
                };
                peer.server = Server::restore(lease(), now, record);
            }
            Self::Client(peer) => {
                peer.client = client(&mut peer.user.rng);
                peer.user.forgets();
                peer.user.plan(now);
            }
        }
    }

    fn insist(&mut self, now: u64) -> bool {
        let Self::Client(peer) = self else { return false };
        peer.user.insist(now);
        true
    }

    fn counts(&self) -> (u64, u64) {
        match self {
            Self::Server(_) => (0, 0),
            Self::Client(peer) => peer.user.counts(),
        }
    }

    fn is_settled(&self) -> bool {
        true
    }

    fn value(&self) -> Option<Value> {
        Some(match self {
            Self::Server(peer) => peer.server.copy().value,
            Self::Client(peer) => peer.client.copy().value,
        })
    }
}
