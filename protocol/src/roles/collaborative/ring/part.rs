//! Part: what a member of a ring is just now, and what it keeps of it.

use super::message::{Ballot, Roster, SEATS, State};

#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant)] // A member of a ring has room for any of them anyway.
pub(super) enum Part {
    Member,
    Candidate(Candidacy),
    Holder(Holding),
    /// Has passed the token, and says so until the next holder is heard.
    Passing {
        to: u8,
        ballot: Ballot,
    },
}

#[derive(Clone, Debug)]
pub(super) struct Candidacy {
    pub(super) votes: Roster,
    /// The newest state that a voter knew, and under which ballot it was kept.
    pub(super) ballot: Ballot,
    pub(super) state: State,
}

impl Candidacy {
    pub(super) fn electorate(&self) -> Roster {
        self.state.everybody()
    }
}

/// What somebody has said about this turn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Held {
    /// When the hold was sent that was answered, µs.
    pub(super) sent_us: u64,
    pub(super) version: u32,
}

/// What the holder is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// Waits until a majority keeps the state; and whether that is a publication of its own.
    Settling {
        publishes: bool,
    },
    Editing {
        since_us: u64,
    },
    /// The state is kept, and there is nothing more to do in this turn.
    Done,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Holding {
    pub(super) held: [Option<Held>; SEATS as usize],
    pub(super) stage: Stage,
    /// It has had its turn: others first.
    pub(super) used: bool,
}

impl Holding {
    pub(super) fn is_editing(&self) -> bool {
        matches!(self.stage, Stage::Editing { .. })
    }

    /// Something of its user's would be lost.
    pub(super) fn is_at_work(&self) -> bool {
        self.is_editing() || self.stage == Stage::Settling { publishes: true }
    }
}

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Other {
    pub(super) heard_us: Option<u64>,
    pub(super) wants: bool,
    pub(super) leaves: bool,
    pub(super) joins: bool,
    /// Turns of this member in which the other was not heard.
    pub(super) missed: u8,
}
