//! What a member does for the others: keeps the state, supports one holder at a time, votes.

use super::message::{Ballot, Message, State};
use super::part::Part;
use super::{Notice, Ring};
use crate::roles::Out;
use crate::wire::PeerId;

impl Ring {
    /// Somebody has the token.
    pub(super) fn hold(
        &mut self,
        now: u64,
        from: u8,
        ballot: Ballot,
        state: State,
        number: u32,
        out: &mut dyn Out<Message>,
    ) {
        self.highest = self.highest.max(ballot.epoch);
        if ballot.epoch < self.record.promised {
            out.send(PeerId(from), Message::Newer { epoch: self.record.promised });
            return;
        }
        if !self.keep(ballot, state) {
            // Said before the token was passed, or before the holder changed the state.
            return;
        }
        self.bound_until_us = self.bound_until_us.max(now.saturating_add(self.config.lease.giver_us()));
        self.supported = Some(from);
        self.put_off(now);
        let (version, wants, leaves) = (state.version, self.wants, self.leaving);
        out.send(PeerId(from), Message::Held { ballot, version, number, wants, leaves });
    }

    /// The token comes here. Only the first time: a ballot that is kept is one that has been heard.
    pub(super) fn passed(&mut self, now: u64, from: u8, ballot: Ballot, state: State, out: &mut dyn Out<Message>) {
        self.highest = self.highest.max(ballot.epoch);
        if ballot.epoch < self.record.promised {
            out.send(PeerId(from), Message::Newer { epoch: self.record.promised });
        } else if ballot > self.record.ballot && self.keep(ballot, state) {
            self.take_token(now, out);
        }
    }

    /// Keeps a state, if it is not older than what is kept.
    fn keep(&mut self, ballot: Ballot, state: State) -> bool {
        let record = &mut self.record;
        if (ballot, state.version) < (record.ballot, record.state.version) {
            return false;
        }
        let higher = ballot > record.ballot;
        record.promised = ballot.epoch;
        record.ballot = ballot;
        record.state = state;
        if higher {
            self.step_back();
        }
        true
    }

    /// Somebody else has a higher right: this one is a member like any other.
    pub(super) fn step_back(&mut self) {
        let told = matches!(&self.part, Part::Holder(holding) if holding.is_at_work());
        self.part = Part::Member;
        if told {
            self.notices.put(Notice::Lost);
        }
    }

    /// Whether this member may vote for a seat: it is bound to nobody else, and does not edit.
    pub(super) fn is_free(&self, now: u64, seat: u8) -> bool {
        let edits = matches!(self.part, Part::Holder(_)) && now < self.lease_until_us(now);
        !edits && (now >= self.bound_until_us || self.supported == Some(seat))
    }

    /// Somebody thinks that the token is lost.
    pub(super) fn elect(&mut self, now: u64, from: u8, epoch: u32, out: &mut dyn Out<Message>) {
        if epoch & 0xf != u32::from(from) {
            return;
        }
        self.highest = self.highest.max(epoch);
        self.tell_off(from, out);
        // Its seat is in the epoch, so that an epoch promised already is one that was promised to it.
        let again = epoch == self.record.promised && self.record.ballot.epoch < epoch;
        if epoch < self.record.promised {
            out.send(PeerId(from), Message::Newer { epoch: self.record.promised });
        } else if again || (epoch > self.record.promised && self.is_free(now, from)) {
            if !again {
                self.step_back();
                self.record.promised = epoch;
                self.put_off(now);
            }
            out.send(PeerId(from), Message::Vote { epoch, ballot: self.record.ballot, state: self.record.state });
        }
    }

    /// Tells somebody whose voice counts no more, for it may not know.
    pub(super) fn tell_off(&self, to: u8, out: &mut dyn Out<Message>) {
        let (ballot, state) = (self.record.ballot, self.record.state);
        if !state.everybody().contains(to) {
            out.send(PeerId(to), Message::Vote { epoch: Self::NO_VOTE, ballot, state });
        }
    }
}
