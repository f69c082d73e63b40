//! Server and clients of a lock as the world sees them. Peer 0 is the server.

use haptic_protocol::roles::collaborative::lock::{self, Client, Message, Notice, Phase, Record, Server};
use haptic_protocol::roles::collaborative::{Lease, Value, Wish};
use haptic_protocol::roles::{Outbox, Role};
use haptic_protocol::wire::{Event, PeerId};

use super::history::History;
use super::user::{LONGEST_EDIT_US, User};
use super::world::{Cast, Peer};
use super::{MOST_USERS, Mistake, Trial};
use haptic_sim::rng::Rng;

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
    out: Outbox<Message, 32>,
    no_fence: bool,
}

/// A client and its user.
pub struct ClientPeer {
    client: Client,
    user: User,
    out: Outbox<Message, 8>,
}

fn lease() -> Lease {
    // In range, or nothing here would work at all.
    Lease::new(LEASE_US).unwrap_or_else(|error| panic!("{error}"))
}

/// A server and the trial's users.
pub fn peers(trial: &Trial) -> Cast<LockPeer> {
    let mut rng = Rng::new(!trial.seed);
    let server = Server::new(lease(), Value::default());
    let stored = server.record().clone();
    let no_fence = trial.mistake == Some(Mistake::NoFence);
    let mut peers = vec![LockPeer::Server(Box::new(ServerPeer { server, stored, out: Outbox::new(), no_fence }))];
    peers.extend((0..trial.users).map(|_| {
        LockPeer::Client(Box::new(ClientPeer {
            client: client(&mut rng),
            user: User::new(0, &mut rng),
            out: Outbox::new(),
        }))
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
    fn step(&mut self, now: u64, message: Option<(PeerId, Message)>, history: &mut History) -> Result<(), String> {
        match message {
            Some((from, Message::Release { fence, value })) if self.no_fence && fence != 0 => {
                // As if the server did not look who it is from, and under which grant.
                let (holder, fence) = (self.server.holder().unwrap_or(from), self.server.record().fence);
                self.server.receive(now, holder, &Message::Release { fence, value }, &mut self.out);
            }
            Some((from, message)) => self.server.receive(now, from, &message, &mut self.out),
            None => self.server.poll(now, &mut self.out),
        }
        self.stored.clone_from(self.server.record());
        history.official(&self.server.copy().value)
    }
}

impl ClientPeer {
    fn step(
        &mut self,
        now: u64,
        message: Option<(PeerId, Message)>,
        history: &mut History,
        rng: &mut Rng,
    ) -> Result<(), String> {
        match message {
            Some((from, message)) => self.client.receive(now, from, &message, &mut self.out),
            None => self.client.poll(now, &mut self.out),
        }
        while let Some(notice) = self.client.take_notice() {
            match notice {
                Notice::Published { version } => self.user.has_published(version, now, history, rng)?,
                Notice::Expired | Notice::TooLate { .. } => self.user.is_interrupted(),
                Notice::Granted | Notice::Changed { .. } => {}
            }
        }
        match (self.user.wish(now), self.client.phase()) {
            (Wish::Edit, Phase::Idle) => self.client.ask(now),
            (Wish::Leave, Phase::Asking) => {
                self.client.withdraw(&mut self.out);
                self.user.plan(now, rng);
            }
            (_, Phase::Owner { .. }) if self.client.owns(now) => {
                if let Some(value) = self.user.edits(now, &self.client.copy().value, history)? {
                    self.client.release(now, Some(value), &mut self.out).map_err(|error| error.to_string())?;
                }
            }
            (Wish::Leave, Phase::Idle) if self.user.is_gone(now) => self.user.plan(now, rng),
            _ => {}
        }
        Ok(())
    }
}

impl Peer for LockPeer {
    fn step(
        &mut self,
        now: u64,
        message: Option<(PeerId, &Event)>,
        history: &mut History,
        rng: &mut Rng,
    ) -> Result<(), String> {
        let message = message.and_then(|(from, event)| match Message::parse(event) {
            Ok((OBJECT, message)) => Some((from, message)),
            _ => None,
        });
        match self {
            Self::Server(peer) => peer.step(now, message, history),
            Self::Client(peer) => peer.step(now, message, history, rng),
        }
    }

    fn say(&mut self) -> Vec<(PeerId, Event)> {
        let event = |message: &Message| message.event(OBJECT);
        match self {
            Self::Server(peer) => peer.out.events(event).collect(),
            Self::Client(peer) => peer.out.events(event).collect(),
        }
    }

    fn owns(&self, now: u64) -> bool {
        matches!(self, Self::Client(peer) if peer.client.owns(now))
    }

    fn restart(&mut self, now: u64, forgets: bool, rng: &mut Rng) {
        match self {
            Self::Server(peer) => {
                let record = if forgets {
                    Server::<CLIENTS>::new(lease(), Value::default()).record().clone()
                } else {
                    peer.stored.clone()
                };
                peer.server = Server::restore(lease(), now, record);
                peer.out = Outbox::new();
            }
            Self::Client(peer) => {
                peer.client = client(rng);
                peer.user.forgets();
                peer.user.plan(now, rng);
                peer.out = Outbox::new();
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
