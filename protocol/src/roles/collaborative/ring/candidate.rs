//! Candidate: how a lost token is made anew, never two of them.

use super::Ring;
use super::message::{Ballot, Message, State};
use super::part::{Candidacy, Part};
use super::roster::Roster;
use crate::roles::Out;

impl Ring {
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
        let (ballot, state) = (self.record.ballot, self.record.state);
        self.part = Part::Candidate(Candidacy { votes: Roster::of([self.config.seat]), ballot, state });
        // Another try, if this one comes to nothing.
        self.put_off(now);
        self.next_us = now.saturating_add(self.config.lease.retry_us());
        self.repeat(now, out);
        self.count(now, out);
    }

    /// A vote, with what the voter knows.
    pub(super) fn voted(
        &mut self,
        now: u64,
        from: u8,
        epoch: u32,
        ballot: Ballot,
        state: State,
        out: &mut dyn Out<Message>,
    ) {
        if epoch == Self::NO_VOTE {
            self.told_off(ballot, state);
            return;
        }
        let Part::Candidate(candidacy) = &mut self.part else { return };
        if epoch != self.record.promised {
            return;
        }
        candidacy.votes = candidacy.votes.with(from);
        if (ballot, state.version) > (candidacy.ballot, candidacy.state.version) {
            candidacy.ballot = ballot;
            candidacy.state = state;
        }
        self.count(now, out);
    }

    /// The token is this one's when the majorities agree, by what the newest state says about who the members are.
    fn count(&mut self, now: u64, out: &mut dyn Out<Message>) {
        let Part::Candidate(Candidacy { votes, ballot, state }) = self.part else { return };
        if !state.roster.contains(self.config.seat) {
            self.told_off(ballot, state);
        } else if state.has_majority(votes) {
            self.record.ballot = Ballot { epoch: self.record.promised, turn: 0 };
            self.record.state = state;
            self.take_token(now, out);
        }
    }

    /// The others have gone on without this one. It keeps what they have, unless it has promised somebody not to: its own
    /// candidacy is over, and binds nobody.
    fn told_off(&mut self, ballot: Ballot, state: State) {
        let record = &mut self.record;
        let newer = (ballot, state.version) > (record.ballot, record.state.version);
        let own = record.promised & 0xf == u32::from(self.config.seat);
        if newer && !state.roster.contains(self.config.seat) && (own || ballot.epoch >= record.promised) {
            record.promised = record.promised.max(ballot.epoch);
            record.ballot = ballot;
            record.state = state;
            self.step_back();
        }
    }

    /// Somebody has promised a higher epoch, and hears this one no longer.
    pub(super) fn overtaken(&mut self, now: u64, epoch: u32) {
        if epoch > self.highest {
            self.highest = epoch;
            if matches!(self.part, Part::Candidate(_)) {
                let wait = self.draw(self.config.lease.giver_us() / 4);
                self.stands_us = now.saturating_add(wait);
            }
        }
    }
}
