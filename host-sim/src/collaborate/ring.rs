//! Members of a token ring as the world sees them. Some begin as founders, one joins later, one leaves.

use haptic_protocol::roles::Outbox;
use haptic_protocol::roles::collaborative::ring::{self, Config, Message, Notice, Record, Ring, Roster};
use haptic_protocol::roles::collaborative::{Lease, Value, Wish};
use haptic_protocol::wire::{Event, PeerId};

use super::hand::{Hand, LONGEST_EDIT_US};
use super::history::History;
use super::world::{Cast, Dice, Peer};
use super::{Mistake, Trial};

/// The object.
const OBJECT: u16 = 9;
/// Lease of the token, µs.
const LEASE_US: u32 = 300_000;
/// A turn while others want to edit, µs: longer than a lease, so that only the lease stops an owner that nobody hears.
const TURN_US: u64 = 600_000;

/// A member, what it has stored, and its user.
pub struct Member {
    ring: Ring,
    config: Config,
    stored: Record,
    /// What a founder begins with, and somebody who has lost its record.
    blank: Record,
    /// Leaves at this time of its own clock, µs.
    leaves_us: Option<u64>,
    hand: Hand,
    patient: bool,
    edited: Option<Value>,
    out: Outbox<Message, 64>,
    published: u64,
    interrupted: u64,
    no_majority: bool,
}

/// The trial's users. With three or more, the last one joins; with four or more, the last but one leaves.
pub fn peers(trial: &Trial) -> Cast<Member> {
    let mut dice = Dice::new(!trial.seed);
    let users = trial.users;
    let lease = Lease::new(LEASE_US).unwrap_or_else(|error| panic!("{error}"));
    let founders = Roster::of(0..users - u8::from(users > 2));
    let everybody = Roster::of(0..users);
    let peers = (0..users)
        .map(|seat| {
            let config = Config { seat, contacts: everybody, lease, turn_us: TURN_US, seed: dice.below(u64::MAX) };
            let record =
                if founders.contains(seat) { Record::founder(founders, Value::default()) } else { Record::outsider() };
            let leaves = users > 3 && seat + 2 == users;
            Member {
                ring: Ring::new(config, 0, record),
                config,
                stored: record,
                blank: record,
                leaves_us: leaves.then(|| 1_000_000 + dice.below(2_000_000)),
                hand: Hand::new(0, &mut dice),
                patient: false,
                edited: None,
                out: Outbox::new(),
                published: 0,
                interrupted: 0,
                no_majority: trial.mistake == Some(Mistake::NoMajority),
            }
        })
        .collect();
    let bound = move |delay_us| ring::wait_bound_us(lease, u64::from(users), LONGEST_EDIT_US, delay_us);
    Cast { peers, wait_bound_us: Box::new(bound) }
}

impl Member {
    fn told(&mut self, now: u64, history: &mut History, dice: &mut Dice) -> Result<(), String> {
        while let Some(notice) = self.ring.take_notice() {
            match notice {
                Notice::Published { version } => {
                    let value = self.edited.take().ok_or_else(|| format!("version {version} was never edited"))?;
                    history.publish(&value)?;
                    self.published += 1;
                    self.hand.plan(now, dice, self.patient);
                    if self.patient {
                        self.hand.rest();
                    }
                }
                Notice::Overdue | Notice::Lost => {
                    self.edited = None;
                    self.interrupted += 1;
                    self.hand.stops();
                }
                Notice::Granted => {}
            }
        }
        Ok(())
    }
}

impl Peer for Member {
    fn step(
        &mut self,
        now: u64,
        message: Option<(PeerId, &Event)>,
        history: &mut History,
        dice: &mut Dice,
    ) -> Result<(), String> {
        match message.map(|(from, event)| (from, Message::parse(event))) {
            Some((_, Ok((OBJECT, vote @ Message::Vote { .. })))) if self.no_majority => {
                for seat in self.config.contacts.seats() {
                    self.ring.receive(now, PeerId(seat), &vote, &mut self.out);
                }
            }
            Some((from, Ok((OBJECT, message)))) => self.ring.receive(now, from, &message, &mut self.out),
            _ => self.ring.poll(now, &mut self.out),
        }
        self.told(now, history, dice)?;
        let wish = self.hand.wish(now);
        if self.leaves_us.is_some_and(|leaves_us| now >= leaves_us) {
            self.ring.leave();
        } else if self.ring.owns(now) {
            if self.hand.edits(now) || wish == Wish::Leave {
                let value = history.edit(&self.ring.state().value)?;
                self.edited = Some(value);
                self.ring.publish(now, value, &mut self.out).map_err(|error| error.to_string())?;
            }
        } else if self.edited.is_none() {
            match wish {
                Wish::Edit => self.ring.ask(),
                Wish::Leave if self.hand.is_gone(now) => {
                    self.ring.give_up(now, &mut self.out);
                    self.hand.plan(now, dice, self.patient);
                }
                _ => {}
            }
        }
        self.told(now, history, dice)?;
        self.stored = *self.ring.record();
        Ok(())
    }

    fn take(&mut self) -> Option<(PeerId, Event)> {
        let (to, message) = self.out.take()?;
        Some((to, message.event(OBJECT).ok()?))
    }

    fn owns(&self, now: u64) -> bool {
        self.ring.owns(now)
    }

    fn restart(&mut self, now: u64, forgets: bool, dice: &mut Dice) {
        self.config.seed = dice.below(u64::MAX);
        self.ring = Ring::new(self.config, now, if forgets { self.blank } else { self.stored });
        self.edited = None;
        self.hand.plan(now, dice, self.patient);
        self.out = Outbox::new();
    }

    fn insist(&mut self, now: u64) -> bool {
        self.patient = true;
        self.hand.insist(now);
        self.leaves_us.is_none()
    }

    fn counts(&self) -> (u64, u64) {
        (self.published, self.interrupted)
    }

    fn is_settled(&self) -> bool {
        self.leaves_us.is_none() || self.ring.has_left()
    }

    fn value(&self) -> Option<Value> {
        // Who has left does not follow any more.
        self.leaves_us.is_none().then_some(self.ring.state().value)
    }
}
