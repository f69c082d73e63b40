//! Members of a token ring as the world sees them. Some begin as founders and the others join; all but the first leave and join
//! again in the time of trouble, and one leaves for good.

use std::cell::RefCell;
use std::rc::Rc;

use haptic_protocol::roles::collaborative::ring::{self, Config, Message, Notice, Record, Ring, Roster};
use haptic_protocol::roles::collaborative::{Lease, Value, Wish};
use haptic_protocol::roles::{Carried as _, Role as _};
use haptic_protocol::wire::{self, PeerId};
use haptic_sim::engine::{Actor, Out};
use haptic_sim::rng::Rng;

use super::history::History;
use super::trial::{Mistake, Trial};
use super::user::{LONGEST_EDIT_US, User};
use super::world::{Cast, Peer};
use crate::shared::said;

/// The object.
const OBJECT: u16 = 9;
/// Lease of the token, µs.
const LEASE_US: u32 = 300_000;
/// A turn while others want to edit, µs: longer than a lease, so that only the lease stops an owner that nobody hears.
const TURN_US: u64 = 600_000;

/// How long after its joining a member leaves at the most, µs.
const LEAVES_US: u64 = 3_000_000;

/// A member, what it has stored, and its user.
pub struct Member {
    ring: Ring,
    config: Config,
    stored: Record,
    /// What a founder begins with, and somebody who has lost its record.
    blank: Record,
    /// Leaves when it has been there for so long, by its own clock, µs.
    stays_us: Option<u64>,
    since_us: Option<u64>,
    for_good: bool,
    user: User,
    no_majority: bool,
}

/// The trial's users. With four or more, the last but one leaves for good.
pub fn peers(trial: &Trial, history: &Rc<RefCell<History>>) -> Cast<Member> {
    let mut rng = Rng::new(!trial.seed);
    let users = trial.users;
    let lease = Lease::new(LEASE_US).unwrap_or_else(|error| panic!("{error}"));
    let founders = Roster::of(0..=rng.below(u64::from(users)) as u8);
    let everybody = Roster::of(0..users);
    let peers = (0..users)
        .map(|seat| {
            let config = Config { seat, contacts: everybody, lease, turn_us: TURN_US, seed: rng.below(u64::MAX) };
            let record =
                if founders.contains(seat) { Record::founder(founders, Value::default()) } else { Record::outsider() };
            let for_good = users > 3 && seat + 2 == users;
            Member {
                ring: Ring::new(config, 0, record),
                config,
                stored: record,
                blank: record,
                stays_us: (seat > 0).then(|| 500_000 + rng.below(LEAVES_US)),
                since_us: None,
                for_good,
                user: User::new(Rng::new(rng.below(u64::MAX)), history),
                no_majority: trial.mistake == Some(Mistake::NoMajority),
            }
        })
        .collect();
    let bound = move |delay_us| ring::wait_bound_us(lease, u64::from(users), LONGEST_EDIT_US, delay_us);
    Cast { peers, wait_bound_us: Box::new(bound) }
}

impl Member {
    /// Another life, with what it has stored or with this record.
    fn begins(&mut self, now: u64, record: Record) {
        self.config.seed = self.user.rng.below(u64::MAX);
        self.ring = Ring::new(self.config, now, record);
        self.user.forgets();
    }

    fn is_told(&mut self, now: u64) {
        while let Some(notice) = self.ring.take_notice() {
            match notice {
                Notice::Published(version) => self.user.has_published(version, now),
                Notice::Overdue | Notice::Lost => {
                    self.user.forgets();
                    self.user.is_interrupted();
                }
                Notice::Granted => {}
            }
        }
    }

    /// What follows from what was heard and from the time.
    fn acts(&mut self, now: u64, out: &mut Out<'_, usize, wire::Message>) {
        let out = &mut said(OBJECT, out);
        self.is_told(now);
        let since_us = *self.since_us.get_or_insert(now);
        if self.stays_us.is_some_and(|stays_us| now - since_us >= stays_us) {
            self.ring.leave();
            if self.ring.has_left() && !self.for_good {
                // Joins again.
                self.begins(now, self.stored);
                self.stays_us = (!self.user.is_patient()).then(|| self.user.rng.below(LEAVES_US));
                self.since_us = Some(now);
            }
        } else if self.ring.owns(now) {
            if let Some(value) = self.user.edits(now, &self.ring.state().value) {
                self.user.must(self.ring.publish(now, value, out));
            }
        } else if !self.user.waits() {
            match self.user.wish(now) {
                Wish::Edit => self.ring.ask(),
                Wish::Leave if self.user.is_gone(now) => {
                    self.ring.give_up(now, out);
                    self.user.plan(now);
                }
                _ => {}
            }
        }
        self.is_told(now);
        self.stored = *self.ring.record();
    }
}

impl Actor<usize> for Member {
    type Packet = wire::Message;

    fn hear(&mut self, now_ns: u64, from: usize, message: &mut wire::Message, out: &mut Out<'_, usize, wire::Message>) {
        let now = now_ns / 1_000;
        let Some((OBJECT, message)) = Message::read(message) else { return };
        let everybody = self.no_majority && matches!(message, Message::Vote { .. });
        let voters = self.config.contacts.seats().filter(|_| everybody);
        for from in voters.chain((!everybody).then_some(from as u8)) {
            self.ring.receive(now, PeerId(from), &message, &mut said(OBJECT, out));
        }
        self.acts(now, out);
    }

    fn speak(&mut self, now_ns: u64, out: &mut Out<'_, usize, wire::Message>) {
        self.ring.poll(now_ns / 1_000, &mut said(OBJECT, out));
        self.acts(now_ns / 1_000, out);
    }
}

impl Peer for Member {
    fn owns(&self, now: u64) -> bool {
        self.ring.owns(now)
    }

    fn restart(&mut self, now: u64, forgets: bool) {
        self.begins(now, if forgets { self.blank } else { self.stored });
        self.user.plan(now);
    }

    fn insist(&mut self, now: u64) -> bool {
        self.user.insist(now);
        if !self.for_good && self.stays_us.take().is_some() {
            // Whether it was about to leave or not, it stays.
            self.ring = Ring::new(self.config, now, self.stored);
            self.user.forgets();
        }
        !self.for_good
    }

    fn counts(&self) -> (u64, u64) {
        self.user.counts()
    }

    fn is_settled(&self) -> bool {
        !self.for_good || self.ring.has_left()
    }

    fn value(&self) -> Option<Value> {
        // Who has left does not follow any more.
        (!self.for_good).then_some(self.ring.state().value)
    }
}
