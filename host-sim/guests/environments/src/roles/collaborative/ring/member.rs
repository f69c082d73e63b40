//! What a member does for the others: keeps the state, supports one holder at a time, votes; and how as a candidate it makes a lost
//! token anew, never two of them.

use cohold_protocol::wire::PeerId;

use super::message::{Ballot, Candidacy, Kept, MemberState, Message, Roster};
use super::{Notice, Record, Ring};
use crate::roles::Out;

impl Ring {
    /// Somebody has the token.
    pub(super) fn hold(&mut self, now: u64, from: u8, kept: Kept, number: u32, out: &mut dyn Out<Message>) {
        // What is older was said before the token was passed, or before the holder changed the state.
        if self.is_past(from, kept.ballot.epoch, out) || !self.keep(kept) {
            return;
        }
        self.bound_until_us = self.bound_until_us.max(now.saturating_add(self.config.lease.giver_us()));
        self.supported = Some(from);
        self.put_off(now);
        let (version, wants, leaves) = (kept.state.version, self.wants, self.leaving);
        out.send(PeerId(from), Message::Held { ballot: kept.ballot, version, number, wants, leaves });
    }

    /// The token comes here. Only the first time: a ballot that is kept is one that has been heard.
    pub(super) fn passed(&mut self, now: u64, from: u8, kept: Kept, out: &mut dyn Out<Message>) {
        let past = self.is_past(from, kept.ballot.epoch, out);
        if !past && kept.ballot > self.record.kept.ballot && self.keep(kept) {
            self.take_token(now, out);
        }
    }

    /// Hears of an epoch; whether it is below what was promised, which is then said.
    fn is_past(&mut self, from: u8, epoch: u32, out: &mut dyn Out<Message>) -> bool {
        self.highest = self.highest.max(epoch);
        let past = epoch < self.record.promised;
        if past {
            out.send(PeerId(from), Message::Newer { epoch: self.record.promised });
        }
        past
    }

    /// Keeps a state, if it is not older than what is kept.
    fn keep(&mut self, kept: Kept) -> bool {
        if kept.age() < self.record.kept.age() {
            return false;
        }
        let higher = kept.ballot > self.record.kept.ballot;
        self.record = Record { promised: kept.ballot.epoch, kept };
        if higher {
            self.step_back();
        }
        true
    }

    /// Somebody else has a higher right: this one is a member like any other.
    pub(super) fn step_back(&mut self) {
        let notified = matches!(&self.part, MemberState::Holder(holding) if holding.is_at_work());
        self.part = MemberState::Member;
        if notified {
            self.notices.put(Notice::Lost);
        }
    }

    /// Whether this member may vote for a seat: it is bound to nobody else, and does not edit.
    pub(super) fn is_free(&self, now: u64, seat: u8) -> bool {
        let edits = matches!(self.part, MemberState::Holder(_)) && now < self.lease_until_us(now);
        !edits && (now >= self.bound_until_us || self.supported == Some(seat))
    }

    /// Somebody thinks that the token is lost.
    pub(super) fn elect(&mut self, now: u64, from: u8, epoch: u32, out: &mut dyn Out<Message>) {
        if epoch & 0xf != u32::from(from) {
            return;
        }
        self.tell_off(from, out);
        // Its seat is in the epoch, so that an epoch promised already is one that was promised to it.
        let again = epoch == self.record.promised && self.record.kept.ballot.epoch < epoch;
        let newer = !self.is_past(from, epoch, out) && epoch > self.record.promised;
        if again || (newer && self.is_free(now, from)) {
            if !again {
                self.step_back();
                self.record.promised = epoch;
                self.put_off(now);
            }
            out.send(PeerId(from), Message::Vote { epoch, kept: self.record.kept });
        }
    }

    /// Tells somebody whose voice counts no more, for it may not know.
    pub(super) fn tell_off(&self, to: u8, out: &mut dyn Out<Message>) {
        let kept = self.record.kept;
        if !kept.state.everybody().contains(to) {
            out.send(PeerId(to), Message::Vote { epoch: Self::NO_VOTE, kept });
        }
    }

    /// Epoch of a vote that is none: a member tells somebody who is no member any more how far the ring has come. The epochs
    /// of tokens begin at 16.
    pub(super) const NO_VOTE: u32 = 0;

    /// Stands for a new token, with an epoch that is higher than any heard of and nobody else's.
    pub(super) fn stand(&mut self, now: u64, out: &mut dyn Out<Message>) {
        let Some(round) = (self.highest >> 4).checked_add(1).filter(|round| *round < 1 << 28) else { return };
        let epoch = round << 4 | u32::from(self.config.seat);
        self.step_back();
        self.highest = epoch;
        self.record.promised = epoch;
        self.part = MemberState::Candidate(Candidacy { votes: Roster::of([self.config.seat]), kept: self.record.kept });
        // Another try, if this one comes to nothing.
        self.put_off(now);
        self.next_us = now.saturating_add(self.config.lease.retry_us());
        self.repeat(now, out);
        self.count(now, out);
    }

    /// A vote, with what the voter knows.
    pub(super) fn voted(&mut self, now: u64, from: u8, epoch: u32, kept: Kept, out: &mut dyn Out<Message>) {
        if epoch == Self::NO_VOTE {
            self.follow(kept);
            return;
        }
        let MemberState::Candidate(candidacy) = &mut self.part else { return };
        if epoch != self.record.promised {
            return;
        }
        candidacy.votes = candidacy.votes.with(from);
        if kept.age() > candidacy.kept.age() {
            candidacy.kept = kept;
        }
        self.count(now, out);
    }

    /// The token is this one's when the majorities agree, by what the newest state says about who the members are.
    fn count(&mut self, now: u64, out: &mut dyn Out<Message>) {
        let MemberState::Candidate(Candidacy { votes, kept }) = self.part else { return };
        if !kept.state.roster.contains(self.config.seat) {
            self.follow(kept);
        } else if kept.state.has_majority(votes) {
            self.record.kept = Kept { ballot: Ballot { epoch: self.record.promised, turn: 0 }, ..kept };
            self.take_token(now, out);
        }
    }

    /// The others have gone on without this one. It keeps what they have, unless it has promised somebody not to: its own
    /// candidacy is over, and binds nobody.
    fn follow(&mut self, kept: Kept) {
        let Record { promised, kept: before } = self.record;
        let own = promised & 0xf == u32::from(self.config.seat);
        let out = kept.age() > before.age() && !kept.state.roster.contains(self.config.seat);
        if out && (own || kept.ballot.epoch >= promised) {
            self.record = Record { promised: promised.max(kept.ballot.epoch), kept };
            self.step_back();
        }
    }

    /// Somebody has promised a higher epoch, and hears this one no longer.
    pub(super) fn overtaken(&mut self, now: u64, epoch: u32) {
        if epoch > self.highest {
            self.highest = epoch;
            if matches!(self.part, MemberState::Candidate(_)) {
                let wait = self.draw(self.config.lease.giver_us() / 4);
                self.stands_us = now.saturating_add(wait);
            }
        }
    }
}
