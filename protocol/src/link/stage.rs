//! Stage: how far two peers have come with each other, and what there is to tell about it.

use super::Link;
use crate::engagement::Rung;
use crate::session::Session;

/// How far two peers have come with each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Stage {
    /// No session: saying hello.
    Calling = 0,
    /// The other peer has proved itself; keys are there, nothing has been heard under them yet.
    Joining = 1,
    /// Heard, but no flow comes: the other peer is there and does not coordinate.
    Idle = 2,
    /// Flow comes.
    Running = 3,
    /// Flow stays away; the coordination lets go.
    Fading = 4,
    /// The other peer was told other parameters; still saying hello, in case it is told better.
    Refused = 5,
}

/// Something that has happened to a link; [`Link::take_notice`] tells each once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notice {
    /// A session is confirmed: there are fresh keys at both ends.
    Joined,
    /// The other peer has started anew since the last session, or is here for the first time. Events that were under way
    /// are dropped.
    NewPeer {
        /// How many events were dropped.
        dropped: u8,
    },
    /// Flow comes: begin the coordination from rest, [`Link::engagement`] rises from 0.
    Engaged,
    /// No flow for 3 packet periods: the engagement falls.
    Fading,
    /// Flow again before the engagement was lost: it rises from where it was.
    Resumed,
    /// The engagement is 0: no flow for 12 packet periods, or the session has ended.
    Disengaged,
    /// The session has ended: a goodbye, silence for 12 packet periods, or the other peer has started another one.
    Lost,
    /// The other peer was told something else.
    Refused {
        /// The first table of parameters that differs.
        table: &'static str,
    },
}

impl Link {
    /// How far the two peers have come with each other, as of the last call.
    pub fn stage(&self) -> Stage {
        match (&self.session, self.engagement.rung()) {
            (None, _) if self.refused.is_some() => Stage::Refused,
            (None, _) => Stage::Calling,
            (Some(session), _) if !session.is_confirmed() => Stage::Joining,
            (Some(_), Rung::Apart) => Stage::Idle,
            (Some(_), Rung::Engaged) => Stage::Running,
            (Some(_), Rung::Fading) => Stage::Fading,
        }
    }

    /// Whether the other peer is there and holds the key.
    pub fn is_up(&self) -> bool {
        matches!(self.stage(), Stage::Idle | Stage::Running | Stage::Fading)
    }

    /// The table of parameters over which the other peer was refused.
    pub fn refused(&self) -> Option<&'static str> {
        self.refused
    }

    /// The oldest notice that has not been told.
    pub fn take_notice(&mut self) -> Option<Notice> {
        self.notices.take()
    }

    /// Tells what has changed since the last time.
    pub(super) fn settle(&mut self) {
        let (before, now) = (self.told, self.stage());
        self.told = now;
        let joined = |stage| matches!(stage, Stage::Idle | Stage::Running | Stage::Fading);
        let engaged = |stage| matches!(stage, Stage::Running | Stage::Fading);
        if engaged(before) && !engaged(now) {
            self.notices.put(Notice::Disengaged);
        }
        if joined(before) && !joined(now) {
            self.notices.put(Notice::Lost);
        }
        if joined(now) && !joined(before) {
            self.notices.put(Notice::Joined);
        }
        match (before, now) {
            (Stage::Running, Stage::Fading) => self.notices.put(Notice::Fading),
            (Stage::Fading, Stage::Running) => self.notices.put(Notice::Resumed),
            _ if engaged(now) && !engaged(before) => self.notices.put(Notice::Engaged),
            _ => {}
        }
        if let (Stage::Refused, Some(table)) = (now, self.refused)
            && before != Stage::Refused
        {
            self.notices.put(Notice::Refused { table });
        }
    }

    /// A session begins; it takes the place of any other.
    pub(super) fn begin(&mut self, session: Session, now: u64) {
        self.end();
        self.session = Some(session);
        self.refused = None;
        self.next_hello_us = now;
        self.next_probe_us = now;
    }

    /// The session ends; the engagement with it.
    pub(super) fn end(&mut self) {
        if let Some(session) = self.session.take() {
            self.past.taken = self.past.taken.saturating_add(session.taken());
            self.past.missing = self.past.missing.saturating_add(session.missing());
        }
        self.engagement.part();
        self.newest_flow = None;
        self.probed = None;
        self.ack_due = false;
        self.settle();
    }
}
