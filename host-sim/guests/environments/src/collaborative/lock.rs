//! Server and clients of a lock. Peer 0 is the server.

use std::{cell::RefCell, rc::Rc};

use cohold_protocol::wire::PeerId;
use cohold_sim::rng::Rng;

use super::history::History;
use super::lease;
use super::trial::{MOST_USERS, Mistake, Trial};
use super::user::{LONGEST_EDIT_US, User};
use crate::roles::collaborative::lock;
use crate::roles::collaborative::lock::{Message, Notice, Phase, Record};
use crate::roles::collaborative::{Value, Wish};
use crate::roles::{Out, Role as _};

const CLIENTS: usize = MOST_USERS as usize;

/// The server and what it has stored.
pub(super) struct Server {
    pub(super) role: lock::Server<CLIENTS>,
    stored: Record<CLIENTS>,
    no_fence: bool,
    history: Rc<RefCell<History>>,
}

/// A client and its user.
pub(super) struct Client {
    pub(super) role: lock::Client,
    pub(super) user: User,
}

/// A server and the trial's users.
pub(super) fn peers(trial: &Trial, history: &Rc<RefCell<History>>) -> (Server, Vec<Client>) {
    let mut rng = Rng::new(!trial.seed);
    let role = lock::Server::new(lease(), Value::default());
    let (stored, no_fence) = (role.record().clone(), trial.mistake == Some(Mistake::NoFence));
    let clients = (0..trial.users).map(|_| {
        let mut user = User::new(Rng::new(rng.below(u64::MAX)), history);
        Client { role: client(&mut user.rng), user }
    });
    (Server { role, stored, no_fence, history: Rc::clone(history) }, clients.collect())
}

/// How long a user may have to wait once all is well, with this one-way delay, µs.
pub(super) fn wait_bound_us(users: u8, delay_us: u64) -> u64 {
    lock::wait_bound_us(lease(), users.into(), LONGEST_EDIT_US, delay_us)
}

fn client(rng: &mut Rng) -> lock::Client {
    lock::Client::new(PeerId(0), lease(), rng.below(1 << 32) as u32, Value::default())
}

impl Server {
    pub(super) fn step(&mut self, now: u64, message: Option<(PeerId, Message)>, out: &mut dyn Out<Message>) {
        match message {
            Some((from, Message::Release { fence, value })) if self.no_fence && fence != 0 => {
                // As if the server did not look who it is from, and under which grant.
                let (holder, fence) = (self.role.holder().unwrap_or(from), self.role.record().fence);
                self.role.receive(now, holder, &Message::Release { fence, value }, out);
            }
            Some((from, message)) => self.role.receive(now, from, &message, out),
            None => self.role.poll(now, out),
        }
        self.stored.clone_from(self.role.record());
        self.history.borrow_mut().official(&self.role.copy().value);
    }

    pub(super) fn restart(&mut self, now: u64, forgets: bool) {
        let blank = || lock::Server::<CLIENTS>::new(lease(), Value::default()).record().clone();
        self.role = lock::Server::restore(lease(), now, if forgets { blank() } else { self.stored.clone() });
    }
}

impl Client {
    pub(super) fn step(&mut self, now: u64, message: Option<(PeerId, Message)>, out: &mut dyn Out<Message>) {
        let Self { role, user } = self;
        match message {
            Some((from, message)) => role.receive(now, from, &message, out),
            None => role.poll(now, out),
        }
        while let Some(notice) = role.take_notice() {
            match notice {
                Notice::Published(version) => user.has_published(version, now),
                Notice::Expired | Notice::TooLate(_) => user.is_interrupted(),
                Notice::Granted | Notice::Changed(_) => {}
            }
        }
        match (user.wish(now), role.phase()) {
            (Wish::Edit, Phase::Idle) => role.ask(now),
            (Wish::Leave, Phase::Asking) => {
                role.withdraw(out);
                user.plan(now);
            }
            (_, Phase::Owner { .. }) if role.owns(now) => {
                if let Some(value) = user.edits(now, &role.copy().value) {
                    user.must(role.release(now, Some(value), out));
                }
            }
            (Wish::Leave, Phase::Idle) if user.is_gone(now) => user.plan(now),
            _ => {}
        }
    }

    pub(super) fn restart(&mut self, now: u64) {
        self.role = client(&mut self.user.rng);
        self.user.edited = None;
        self.user.plan(now);
    }
}
