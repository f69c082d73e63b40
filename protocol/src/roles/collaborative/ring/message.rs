//! What the members of a ring say to each other; the event's code is [`code::RING`].

use super::roster::Roster;
use crate::bytes::{layout, messages};
use crate::roles::collaborative::Value;
use crate::roles::{carried_by_events, code};

layout! {
    /// A right to propose: which token, and which of its turns.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
    pub struct Ballot(8 bytes) {
        /// Which token. The low 4 bits are the seat of who made it.
        0 => epoch: u32,
        /// How often it has been passed.
        4 => turn: u32,
    }
}

layout! {
    /// What is passed around: the object, and who the members are.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct State(32 bytes) {
        /// How often it has been changed.
        0 => version: u32,
        /// The members.
        4 => roster: Roster,
        /// The members before this version.
        6 => before: Roster,
        /// What the object is.
        8 => value: Value,
    }
}

impl State {
    /// Whether this is a majority of the members, and of those before.
    pub(super) fn has_majority(&self, votes: Roster) -> bool {
        let majority = |roster: Roster| Roster(roster.0 & votes.0).len() >= roster.majority();
        majority(self.roster) && majority(self.before)
    }

    /// Everybody who has a say in it.
    pub(super) fn everybody(&self) -> Roster {
        self.roster.union(self.before)
    }
}

messages! {
    /// A message about one object.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Message("ring", code::RING, about 1) {
        /// Holder: I have the token; keep this state, and vote for nobody else for a lease.
        Hold = 1, 48 bytes {
            /// The holder's.
            4 => ballot: Ballot,
            /// The object and its members.
            12 => state: State,
            /// 1, 2, 3 … in the order of sending.
            44 => number: u32,
        }
        /// Member: so be it.
        Held = 2, 20 bytes {
            /// Of the hold.
            4 => ballot: Ballot,
            /// Of the state that is kept.
            12 => version: u32,
            /// Of the hold.
            16 => number: u32,
        }, flags {
            /// It would like to edit.
            wants: bool,
            /// It would like to leave the ring.
            leaves: bool,
        }
        /// Holder: the token is yours.
        Pass = 3, 44 bytes {
            /// The next holder's.
            4 => ballot: Ballot,
            /// The object and its members.
            12 => state: State,
        }
        /// Candidate: the token seems to be lost; may I make a new one?
        Elect = 4, 8 bytes {
            /// Of the new token; no two candidates have the same.
            4 => epoch: u32,
        }
        /// Member: you may, and this is the newest that I know. I hear no lower epoch from now on.
        Vote = 5, 48 bytes {
            /// Of the new token.
            4 => epoch: u32,
            /// Under which the state was kept.
            8 => ballot: Ballot,
            /// The object and its members.
            16 => state: State,
        }
        /// Member: I have promised to hear no epoch below this.
        Newer = 6, 8 bytes {
            /// The promise.
            4 => epoch: u32,
        }
        /// Somebody who would like to be a member.
        Join = 7, 4 bytes
        /// A member who would like to leave, and to be told when it has.
        Leave = 8, 4 bytes
    }
}

carried_by_events!(Message);
