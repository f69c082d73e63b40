//! Members of a token ring. Some begin as founders and the others join; all but the first leave and join again in the time of
//! trouble, and one leaves for good.

use std::{cell::RefCell, rc::Rc};

use cohold_protocol::wire::PeerId;
use cohold_sim::rng::Rng;

use super::history::History;
use super::lease;
use super::trial::{Mistake, Trial};
use super::user::{LONGEST_EDIT_US, User};
use crate::roles::collaborative::ring;
use crate::roles::collaborative::ring::{Config, Message, Notice, Record, Ring, Roster};
use crate::roles::collaborative::{Value, Wish};
use crate::roles::{Out, Role as _};

/// A turn while others want to edit, µs: longer than a lease, so that only the lease stops an owner that nobody hears.
const TURN_US: u64 = 600_000;
/// How long after its joining a member leaves at the most, µs.
const LEAVES_US: u64 = 3_000_000;

/// A member, what it has stored, and its user.
pub(super) struct Member {
    pub(super) ring: Ring,
    config: Config,
    stored: Record,
    /// What a founder begins with, and somebody who has lost its record.
    blank: Record,
    /// Leaves when it has been there for so long, by its own clock, µs.
    stays_us: Option<u64>,
    since_us: Option<u64>,
    pub(super) for_good: bool,
    pub(super) user: User,
    no_majority: bool,
}

/// The trial's users. With four or more, the last but one leaves for good.
pub(super) fn peers(trial: &Trial, history: &Rc<RefCell<History>>) -> Vec<Member> {
    let mut rng = Rng::new(!trial.seed);
    let users = trial.users;
    let founders = Roster::of(0..=rng.below(u64::from(users)) as u8);
    let member = |seat: u8| {
        let contacts = Roster::of(0..users);
        let config = Config { seat, contacts, lease: lease(), turn_us: TURN_US, seed: rng.below(u64::MAX) };
        let founds = founders.contains(seat);
        let record = if founds { Record::founder(founders, Value::default()) } else { Record::outsider() };
        Member {
            ring: Ring::new(config, 0, record),
            config,
            stored: record,
            blank: record,
            stays_us: (seat > 0).then(|| 500_000 + rng.below(LEAVES_US)),
            since_us: None,
            for_good: users > 3 && seat + 2 == users,
            user: User::new(Rng::new(rng.below(u64::MAX)), history),
            no_majority: trial.mistake == Some(Mistake::NoMajority),
        }
    };
    (0..users).map(member).collect()
}

/// How long a user may have to wait once all is well, with this one-way delay, µs.
pub(super) fn wait_bound_us(users: u8, delay_us: u64) -> u64 {
    ring::wait_bound_us(lease(), users.into(), LONGEST_EDIT_US, delay_us)
}

impl Member {
    /// Another life, with what it has stored or with this record.
    fn begins(&mut self, now: u64, record: Record) {
        self.config.seed = self.user.rng.below(u64::MAX);
        self.ring = Ring::new(self.config, now, record);
        self.user.edited = None;
    }

    fn take_notices(&mut self, now: u64) {
        while let Some(notice) = self.ring.take_notice() {
            match notice {
                Notice::Published(version) => self.user.has_published(version, now),
                Notice::Overdue | Notice::Lost => {
                    self.user.edited = None;
                    self.user.is_interrupted();
                }
                Notice::Granted => {}
            }
        }
    }

    pub(super) fn step(&mut self, now: u64, message: Option<(PeerId, Message)>, out: &mut dyn Out<Message>) {
        match message {
            Some((_, message @ Message::Vote { .. })) if self.no_majority => {
                self.config.contacts.seats().for_each(|voter| self.ring.receive(now, PeerId(voter), &message, out));
            }
            Some((from, message)) => self.ring.receive(now, from, &message, out),
            None => self.ring.poll(now, out),
        }
        self.take_notices(now);
        let since_us = *self.since_us.get_or_insert(now);
        if self.stays_us.is_some_and(|stays_us| now - since_us >= stays_us) {
            self.ring.leave();
            if self.ring.has_left() && !self.for_good {
                // Joins again.
                self.begins(now, self.stored);
                self.stays_us = (!self.user.patient).then(|| self.user.rng.below(LEAVES_US));
                self.since_us = Some(now);
            }
        } else if self.ring.owns(now) {
            if let Some(value) = self.user.edits(now, &self.ring.state().value) {
                self.user.must(self.ring.publish(now, value, out));
            }
        } else if self.user.edited.is_none() {
            match self.user.wish(now) {
                Wish::Edit => self.ring.ask(),
                Wish::Leave if self.user.is_gone(now) => {
                    self.ring.give_up(now, out);
                    self.user.plan(now);
                }
                _ => {}
            }
        }
        self.take_notices(now);
        self.stored = *self.ring.record();
    }

    pub(super) fn restart(&mut self, now: u64, forgets: bool) {
        self.begins(now, if forgets { self.blank } else { self.stored });
        self.user.plan(now);
    }

    /// Whether it was about to leave or not, it stays, unless it is to leave for good.
    pub(super) fn stay(&mut self, now: u64) {
        if !self.for_good && self.stays_us.take().is_some() {
            self.ring = Ring::new(self.config, now, self.stored);
            self.user.edited = None;
        }
    }
}
