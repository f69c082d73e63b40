//! Token ring: the right to edit goes round; there is no server and no official copy (Buttolo et al. 1997, §3.2, scheme 2).
//!
//! ```text
//!            Pass to me                  majority says Held           publish, stored by a majority
//! Member ────────────────► Holder: settling ──────────► editing ─────────────────► settling ──► Pass ──► Member
//!    │ no token for a lease                                  │ or resting, while nobody wants the token
//!    └───► Candidate ──majority votes──► Holder
//! ```
//!
//! | rule | because |
//! |---|---|
//! | every right has a **ballot**: epoch, then turn; a pass adds a turn, a new token has a new epoch. A member hears no ballot below the highest it has heard | a token that comes late or twice is nobody's |
//! | who has the token edits only while a majority has said, within a [`Lease`], that it votes for nobody else | a new token is made after the old one's holder has stopped, wherever it is |
//! | an update is published when a majority keeps it; a candidate begins from the newest state that a majority knows | two majorities meet: what is published is in every later state |
//! | a next version is proposed when the last one is kept by a majority; a change of members counts in the majorities before and after | majorities meet across joins and leaves, too |
//! | the token goes to the next in the ring who wants it, and rests where it is when nobody does | turns, without traffic for nothing |
//!
//! This is Paxos (Lamport 1998) for one register, its leader's lease passed from hand to hand; after a pass the new leader need
//! not ask what was decided, because the old one tells it.
//!
//! **Progress**: while a majority of the members are up and hear each other within less than a third of a lease, whoever wants
//! the token gets it within [`wait_bound_us`]. Without a majority nobody edits: two members of two, two of three, three of
//! five are needed. A holder leaves out who has not been heard for 8 turns and 8 leases; who finds itself left out joins anew.
//! **Limits**: [`SEATS`] members; epochs are 28 bits; turns, versions and a member's holds between two starts 32 (6 years of
//! having the token under a lease of 300 ms, 82 days under the shortest).

use cohold_protocol::{notices::Notices, wire::PeerId};

use super::lease::Requests;
use super::{Lease, NotOwner, Value};
use crate::roles::{Out, Role};

mod holder;
mod member;
mod message;

pub use message::{Ballot, Kept, Message, Roster, SEATS, State};
use message::{MemberRecord, MemberState};

/// What a member must still know after a crash. Store it before sending what came with the change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record {
    /// No lower epoch is heard.
    pub promised: u32,
    /// The newest state that is kept here, and under which ballot.
    pub kept: Kept,
}

impl Record {
    /// One of the founders of a ring, all of whom begin with the same.
    pub fn founder(founders: Roster, value: Value) -> Self {
        let state = State { version: 0, roster: founders, before: founders, value };
        Self { promised: 0, kept: Kept { ballot: Ballot::default(), state } }
    }

    /// Somebody who will join.
    pub fn outsider() -> Self {
        Self::founder(Roster::EMPTY, Value::default())
    }
}

/// Settings of a member.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// Its number, below [`SEATS`]: `PeerId(seat)`.
    pub seat: u8,
    /// Where a member may be found, to join.
    pub contacts: Roster,
    /// For the right to edit.
    pub lease: Lease,
    /// How long one may edit while others want to, µs.
    pub turn_us: u64,
    /// Any number, another one for each member and start: candidates draw from it, so that they do not go on meeting.
    pub seed: u64,
}

/// What a member has to tell its user.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notice {
    /// The right to edit is granted.
    Granted,
    /// Its edit is kept by a majority, as this version.
    Published(u32),
    /// Its turn was over before it had published: what it edited stays local.
    Overdue,
    /// The token was made anew elsewhere. What it edited stays local; what it was publishing may have been taken or not.
    Lost,
}

/// A member of a ring.
#[derive(Clone, Debug)]
pub struct Ring {
    config: Config,
    record: Record,
    part: MemberState,
    wants: bool,
    leaving: bool,
    /// No vote before, but for the one that is supported.
    bound_until_us: u64,
    supported: Option<u8>,
    /// A candidate if nothing is heard until then.
    stands_us: u64,
    /// The highest epoch heard of.
    highest: u32,
    /// When something is to be said again.
    next_us: u64,
    holds: Requests,
    others: [MemberRecord; SEATS as usize],
    random: u64,
    notices: Notices<Notice, 8>,
}

impl Ring {
    /// A member at its first start or after a crash, from its record. It votes for nobody before one lease is over, for it
    /// may have said so to somebody.
    pub fn new(config: Config, now: u64, record: Record) -> Self {
        let mut ring = Self {
            config,
            record,
            part: MemberState::Member,
            wants: false,
            leaving: false,
            bound_until_us: if record.promised == 0 { now } else { now.saturating_add(config.lease.giver_us()) },
            supported: None,
            stands_us: 0,
            highest: record.promised,
            next_us: now,
            holds: Requests::default(),
            others: [MemberRecord::default(); SEATS as usize],
            random: config.seed,
            notices: Notices::default(),
        };
        ring.put_off(now);
        ring
    }

    /// The record to store before anything is sent.
    pub fn record(&self) -> &Record {
        &self.record
    }

    /// The newest state that is known here; while this member edits, what there was to edit.
    pub fn state(&self) -> &State {
        &self.record.kept.state
    }

    /// Whether it may edit now.
    pub fn owns(&self, now: u64) -> bool {
        matches!(&self.part, MemberState::Holder(holding) if holding.is_editing()) && now < self.lease_until_us(now)
    }

    /// The user comes near: it wants to edit.
    pub fn ask(&mut self) {
        self.wants = true;
    }

    /// The user moves away, or has changed nothing.
    pub fn give_up(&mut self, now: u64, out: &mut dyn Out<Message>) {
        self.wants = false;
        self.end_turn();
        self.poll(now, out);
    }

    /// The user leaves the ring for good; [`Ring::has_left`] says when it may be switched off.
    pub fn leave(&mut self) {
        self.leaving = true;
        self.wants = false;
    }

    /// The ring goes on without this member: its voice counts no more.
    pub fn has_left(&self) -> bool {
        self.leaving && !self.record.kept.state.everybody().contains(self.config.seat)
    }

    /// The user has finished: this is what the object is now. From now on it does not own the object.
    ///
    /// # Errors
    /// This member does not own the object.
    pub fn publish(&mut self, now: u64, value: Value, out: &mut dyn Out<Message>) -> Result<(), NotOwner> {
        if !self.owns(now) {
            return Err(NotOwner);
        }
        self.wants = false;
        self.propose(now, value, true, out);
        Ok(())
    }

    /// What has not been answered is said again.
    fn repeat(&mut self, now: u64, out: &mut dyn Out<Message>) {
        match &self.part {
            MemberState::Member if self.leaving && !self.has_left() => {
                self.tell(self.config.contacts, Message::Leave, out)
            }
            MemberState::Member if self.leaving || self.record.kept.state.roster.contains(self.config.seat) => {}
            MemberState::Member => self.tell(self.config.contacts, Message::Join, out),
            MemberState::Candidate(candidacy) => {
                let (to, epoch) = (candidacy.electorate(), self.record.promised);
                self.tell(to, Message::Elect { epoch }, out);
            }
            MemberState::Holder(_) => self.say_hold(now, out),
            MemberState::Passing { to, ballot } => {
                out.send(PeerId(*to), Message::Pass { kept: Kept { ballot: *ballot, ..self.record.kept } });
            }
        }
    }

    /// To each of these but oneself.
    fn tell(&self, to: Roster, message: Message, out: &mut dyn Out<Message>) {
        for seat in to.without(self.config.seat).seats() {
            out.send(PeerId(seat), message);
        }
    }

    fn note(&mut self, seat: u8, change: impl FnOnce(&mut MemberRecord)) {
        if let Some(other) = self.others.get_mut(usize::from(seat)) {
            change(other);
        }
    }

    /// Waits for a lease, and longer the later this seat comes in the ring, before it makes a new token.
    fn put_off(&mut self, now: u64) {
        let lease = self.config.lease.giver_us();
        let first = self.supported.unwrap_or(0);
        let place = self.record.kept.state.roster.after(first).take_while(|seat| *seat != self.config.seat).count();
        let wait = lease.saturating_add((place as u64).saturating_mul(lease / 4)).saturating_add(self.draw(lease / 4));
        self.stands_us = now.saturating_add(wait);
    }

    /// Any number below `end`; splitmix64.
    fn draw(&mut self, end: u64) -> u64 {
        self.random = self.random.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.random ^ (self.random >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed.checked_rem(end).unwrap_or(0)
    }
}

impl Role for Ring {
    type Message = Message;
    type Notice = Notice;

    fn receive(&mut self, now: u64, from: PeerId, message: &Message, out: &mut dyn Out<Message>) {
        let seat = from.0;
        if seat >= SEATS || seat == self.config.seat {
            return;
        }
        match *message {
            Message::Hold { kept, number } => self.hold(now, seat, kept, number, out),
            Message::Held { ballot, version, number, wants, leaves } => {
                self.note(seat, |other| {
                    *other = MemberRecord { heard_us: Some(now), wants, leaves, ..*other };
                });
                self.held(seat, ballot, version, number);
            }
            Message::Pass { kept } => self.passed(now, seat, kept, out),
            Message::Elect { epoch } => self.elect(now, seat, epoch, out),
            Message::Vote { epoch, kept } => self.voted(now, seat, epoch, kept, out),
            Message::Newer { epoch } => self.overtaken(now, epoch),
            Message::Leave => {
                self.note(seat, |other| *other = MemberRecord { joins: false, leaves: true, ..*other });
                self.tell_off(seat, out);
            }
            Message::Join => self.note(seat, |other| *other = MemberRecord { joins: true, leaves: false, ..*other }),
        }
        self.settle(now, out);
    }

    fn poll(&mut self, now: u64, out: &mut dyn Out<Message>) {
        self.settle(now, out);
        let member = self.record.kept.state.roster.contains(self.config.seat);
        if member
            && !matches!(self.part, MemberState::Holder(_))
            && now >= self.stands_us
            && self.is_free(now, self.config.seat)
        {
            self.stand(now, out);
        }
        if now >= self.next_us {
            self.next_us = now.saturating_add(self.config.lease.retry_us());
            self.repeat(now, out);
        }
    }

    fn take_notice(&mut self) -> Option<Notice> {
        self.notices.take()
    }
}

/// How long a member that wants the token may have to wait for it, µs, if from now on no message takes longer than `delay_us`,
/// none is lost and nobody crashes: a lease that must run out, or be waited for after a restart; candidates in their order,
/// three of whom may fail against each other; then every other member once, `turn_us` at the most and eight messages.
pub fn wait_bound_us(lease: Lease, members: u64, turn_us: u64, delay_us: u64) -> u64 {
    let (lease, retry) = (lease.giver_us(), lease.retry_us());
    let election = (lease / 4).saturating_mul(members.saturating_add(1)).saturating_add(lease);
    let turn = turn_us.saturating_add(delay_us.saturating_mul(8)).saturating_add(retry.saturating_mul(2));
    lease.saturating_add(election.saturating_mul(3)).saturating_add(turn.saturating_mul(members))
}
