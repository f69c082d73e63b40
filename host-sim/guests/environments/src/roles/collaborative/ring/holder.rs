//! Holder: keeps the support of a majority, edits, publishes, passes the token on.

use cohold_protocol::wire::PeerId;

use super::message::{Ballot, Held, Holding, Kept, MemberRecord, MemberState, Message, Roster, SEATS, Stage, State};
use super::{Notice, Ring};
use crate::{roles::Out, roles::collaborative::Value};

/// Turns and leases of silence after which a member is left out.
const ABSENT_AFTER: u8 = 8;

impl Ring {
    /// Others first, from now on.
    pub(super) fn end_turn(&mut self) {
        if let MemberState::Holder(holding) = &mut self.part {
            holding.used = true;
            if holding.is_editing() {
                holding.stage = Stage::Done;
            }
        }
    }

    /// The token is here; whether anybody may edit, the others say.
    pub(super) fn take_token(&mut self, now: u64, out: &mut dyn Out<Message>) {
        let held = [None; SEATS as usize];
        self.part = MemberState::Holder(Holding { held, stage: Stage::Settling { publishes: false }, used: false });
        self.supported = Some(self.config.seat);
        self.say_hold(now, out);
    }

    /// Says that the token is here, to everybody who has a say.
    pub(super) fn say_hold(&mut self, now: u64, out: &mut dyn Out<Message>) {
        let number = self.holds.send(now);
        self.next_us = now.saturating_add(self.config.lease.retry_us());
        let kept = self.record.kept;
        self.tell(kept.state.everybody(), Message::Hold { kept, number }, out);
    }

    /// Somebody keeps the state and votes for nobody else.
    pub(super) fn held(&mut self, from: u8, ballot: Ballot, version: u32, number: u32) {
        let (MemberState::Holder(holding), Some(sent_us)) = (&mut self.part, self.holds.sent_us(number)) else {
            return;
        };
        if ballot != self.record.kept.ballot {
            return;
        }
        if let Some(held) = holding.held.get_mut(usize::from(from)) {
            let before = held.unwrap_or(Held { sent_us: 0, version: 0 });
            *held = Some(Held { sent_us: before.sent_us.max(sent_us), version: before.version.max(version) });
        }
    }

    /// Until when a majority votes for nobody else, µs: what the slowest of the quickest majority has answered to.
    pub(super) fn lease_until_us(&self, now: u64) -> u64 {
        let MemberState::Holder(holding) = &self.part else { return 0 };
        let majority = |roster: Roster| {
            let mut sent = heapless::Vec::<u64, { SEATS as usize }>::new();
            for seat in roster.seats() {
                let answered = holding.held.get(usize::from(seat)).copied().flatten().map_or(0, |held| held.sent_us);
                // There are as many places as seats.
                let _ = sent.push(if seat == self.config.seat { now } else { answered });
            }
            sent.sort_unstable_by(|one, two| two.cmp(one));
            sent.get((roster.majority() - 1) as usize).copied().unwrap_or(0)
        };
        let State { roster, before, .. } = self.record.kept.state;
        match majority(roster).min(majority(before)) {
            0 => 0,
            sent_us => sent_us.saturating_add(self.config.lease.holder_us()),
        }
    }

    /// The next version: this value, and the members as they want to be.
    pub(super) fn propose(&mut self, now: u64, value: Value, publishes: bool, out: &mut dyn Out<Message>) {
        let roster = self.next_roster(now);
        let MemberState::Holder(holding) = &mut self.part else { return };
        let State { version, roster: before, .. } = self.record.kept.state;
        let Some(version) = version.checked_add(1) else { return };
        self.record.kept.state = State { version, roster, before, value };
        holding.stage = Stage::Settling { publishes };
        holding.used = true;
        self.settle_members();
        self.say_hold(now, out);
    }

    /// The members as they want to be: who joins, without who leaves or has not been heard for long.
    fn next_roster(&self, now: u64) -> Roster {
        let long = self.config.lease.giver_us().saturating_mul(u64::from(ABSENT_AFTER));
        let mut roster = self.record.kept.state.roster;
        for (seat, other) in (0..SEATS).zip(&self.others) {
            let silent = other.heard_us.is_none_or(|heard_us| now.saturating_sub(heard_us) >= long);
            let absent = other.missed >= ABSENT_AFTER && silent;
            if roster.contains(seat) && seat != self.config.seat && (other.leaves || absent) {
                roster = roster.without(seat);
            } else if other.joins && !other.leaves {
                roster = roster.with(seat);
            }
        }
        // Who leaves last puts out the light; before, the token goes to somebody else.
        if self.leaving && roster.len() == 1 { Roster::EMPTY } else { roster }
    }

    /// Does whatever can be done now.
    pub(super) fn settle(&mut self, now: u64, out: &mut dyn Out<Message>) {
        if !matches!(self.part, MemberState::Holder(_)) {
            return;
        }
        if self.highest > self.record.promised && now >= self.lease_until_us(now) {
            // A majority may have promised a higher epoch, and hear this token no longer.
            self.stand(now, out);
            return;
        }
        let kept = self.kept();
        let MemberState::Holder(holding) = &mut self.part else { return };
        match holding.stage {
            Stage::Settling { publishes } => {
                if !self.record.kept.state.has_majority(kept) {
                    return;
                }
                holding.stage = Stage::Done;
                if publishes {
                    self.notices.put(Notice::Published(self.record.kept.state.version));
                }
            }
            Stage::Editing { since_us } => {
                if now.saturating_sub(since_us) < self.config.turn_us || self.next_in_turn(now).is_none() {
                    return;
                }
                self.end_turn();
                self.wants = false;
                self.notices.put(Notice::Overdue);
            }
            Stage::Done => {}
        }
        self.go_on(now, out);
    }

    /// Who keeps the newest state.
    fn kept(&self) -> Roster {
        let own = Roster::of([self.config.seat]);
        let MemberState::Holder(holding) = &self.part else { return own };
        let keeps = |held: &Option<Held>| held.is_some_and(|held| held.version == self.record.kept.state.version);
        let others = (0..SEATS).zip(&holding.held).filter(|(_, held)| keeps(held));
        others.fold(own, |kept, (seat, _)| kept.with(seat))
    }

    /// The state is kept by a majority: what next?
    fn go_on(&mut self, now: u64, out: &mut dyn Out<Message>) {
        let (next, live) = (self.next_in_turn(now), now < self.lease_until_us(now));
        let MemberState::Holder(holding) = &mut self.part else { return };
        if self.wants && !(holding.used && next.is_some()) {
            if live {
                holding.stage = Stage::Editing { since_us: now };
                self.notices.put(Notice::Granted);
            }
        } else if self.is_between() || self.next_roster(now) != self.record.kept.state.roster {
            // Somebody comes or goes; or has, and then once more, so that who has gone counts no more.
            self.propose(now, self.record.kept.state.value, false, out);
        } else if self.highest > self.record.promised {
            // Some have promised more, and would be left behind.
            self.stand(now, out);
        } else if let Some(to) = next {
            self.pass(now, to, out);
        }
    }

    /// The members have just changed.
    fn is_between(&self) -> bool {
        self.record.kept.state.roster != self.record.kept.state.before
    }

    /// Who has come or gone has no open wish any more.
    fn settle_members(&mut self) {
        let roster = self.record.kept.state.roster;
        for (seat, other) in (0..SEATS).zip(&mut self.others) {
            other.joins &= !roster.contains(seat);
            if !roster.contains(seat) {
                *other = MemberRecord { joins: other.joins, ..MemberRecord::default() };
            }
        }
    }

    /// The next in the ring who wants the token and was heard within a lease; if this one leaves, whoever was heard.
    fn next_in_turn(&self, now: u64) -> Option<u8> {
        let lease = self.config.lease.giver_us();
        self.record.kept.state.roster.after(self.config.seat).filter(|seat| *seat != self.config.seat).find(|seat| {
            let Some(other) = self.others.get(usize::from(*seat)) else { return false };
            let heard = other.heard_us.is_some_and(|heard_us| now.saturating_sub(heard_us) < lease);
            heard && !other.leaves && (other.wants || self.leaving)
        })
    }

    fn pass(&mut self, now: u64, to: u8, out: &mut dyn Out<Message>) {
        let Ballot { epoch, turn } = self.record.kept.ballot;
        let (MemberState::Holder(holding), Some(turn)) = (&self.part, turn.checked_add(1)) else { return };
        let roster = self.record.kept.state.roster;
        for ((seat, other), held) in (0..SEATS).zip(&mut self.others).zip(&holding.held) {
            let missed = held.is_none() && roster.contains(seat);
            other.missed = if missed { other.missed.saturating_add(1) } else { 0 };
        }
        let ballot = Ballot { epoch, turn };
        self.part = MemberState::Passing { to, ballot };
        self.supported = None;
        // It is served: what it wants now it will say again.
        self.note(to, |other| other.wants = false);
        self.put_off(now);
        self.next_us = now.saturating_add(self.config.lease.retry_us());
        out.send(PeerId(to), Message::Pass { kept: Kept { ballot, ..self.record.kept } });
    }
}
