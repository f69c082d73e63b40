//! Progress: from stage to stage, and a notice of every change.

use super::{Link, Notice, Stage};
use crate::{engagement::Rung, session::Session};

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
            self.notices.put(Notice::Refused(table));
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
