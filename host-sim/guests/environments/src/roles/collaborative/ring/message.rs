//! Who the members of a ring are, what they say to each other, and what each is just now.

use cohold_protocol::bytes::{layout, newtype};

use crate::roles::collaborative::Value;
use crate::roles::messages::messages;

/// Seats there can be: the peers numbered 0 to 15.
pub const SEATS: u8 = 16;

/// A set of seats.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Roster(pub(super) u16);

newtype!(Roster);

impl Roster {
    /// The roster without any member.
    pub const EMPTY: Self = Self(0);

    /// These seats; a number from [`SEATS`] up is none.
    pub fn of(seats: impl IntoIterator<Item = u8>) -> Self {
        seats.into_iter().fold(Self::EMPTY, Self::with)
    }

    /// The set with this seat.
    #[must_use]
    pub fn with(self, seat: u8) -> Self {
        Self(self.0 | Self::bit(seat))
    }

    /// The set without this seat.
    #[must_use]
    pub fn without(self, seat: u8) -> Self {
        Self(self.0 & !Self::bit(seat))
    }

    /// The members of both rosters.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether the seat is one of them.
    pub fn contains(self, seat: u8) -> bool {
        self.0 & Self::bit(seat) != 0
    }

    /// How many they are.
    pub fn len(self) -> u32 {
        self.0.count_ones()
    }

    /// Whether the roster has no member.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// How many of them are more than half: at least 1, so that nobody is no majority of nothing.
    pub fn majority(self) -> u32 {
        self.len() / 2 + 1
    }

    /// Seats of the members, in ascending order.
    pub fn seats(self) -> impl Iterator<Item = u8> {
        (0..SEATS).filter(move |seat| self.contains(*seat))
    }

    /// The seats in the order of the ring, beginning after `seat` and ending with it.
    pub fn after(self, seat: u8) -> impl Iterator<Item = u8> {
        (1..=SEATS).map(move |step| seat.wrapping_add(step) % SEATS).filter(move |seat| self.contains(*seat))
    }

    fn bit(seat: u8) -> u16 {
        1_u16.checked_shl(u32::from(seat)).unwrap_or(0)
    }
}

layout! {
    /// A right to propose: which token, and which of its turns.
    #[derive(Eq, PartialOrd, Ord)]
    pub struct Ballot(8 bytes) {
        0 => epoch: u32, "Which token. The low 4 bits are the seat of who made it.";
        4 => turn: u32, "How often it has been passed.";
    }
}

layout! {
    /// The token: the object, and who the members are.
    pub struct State(32 bytes) {
        0 => version: u32, "How often it has been changed.";
        4 => roster: Roster, "The members.";
        6 => before: Roster, "The members before this version.";
        8 => value: Value, "What the object is.";
    }
}

layout! {
    /// A state, and the ballot under which it is kept.
    pub struct Kept(40 bytes) {
        0 => ballot: Ballot, "By what right it was proposed.";
        8 => state: State, "The object and its members.";
    }
}

impl Kept {
    /// The higher the newer.
    pub(super) fn age(&self) -> (Ballot, u32) {
        (self.ballot, self.state.version)
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
    pub enum Message("ring", code 0x0102, about 1) {
        /// Holder: I have the token; keep this state, and vote for nobody else for a lease.
        Hold = 1, 48 bytes:
            4 => kept: Kept, "Under the holder's ballot.";
            44 => number: u32, "1, 2, 3 … in the order of sending.";
        /// Member: so be it.
        Held = 2, 20 bytes:
            4 => ballot: Ballot, "Of the hold.";
            12 => version: u32, "Of the state that is kept.";
            16 => number: u32, "Of the hold.";
            flags
                wants: bool, "It would like to edit.";
                leaves: bool, "It would like to leave the ring.";
        /// Holder: the token is yours.
        Pass = 3, 44 bytes:
            4 => kept: Kept, "Under the next holder's ballot.";
        /// Candidate: the token seems to be lost; may I make a new one?
        Elect = 4, 8 bytes:
            4 => epoch: u32, "Of the new token; no two candidates have the same.";
        /// Member: you may, and this is the newest that I know. I hear no lower epoch from now on.
        Vote = 5, 48 bytes:
            4 => epoch: u32, "Of the new token.";
            8 => kept: Kept, "The newest that the voter knows.";
        /// Member: I have promised to hear no epoch below this.
        Newer = 6, 8 bytes:
            4 => epoch: u32, "The promise.";
        /// Somebody who would like to be a member.
        Join = 7, 4 bytes
        /// A member who would like to leave, and to be notified when it has.
        Leave = 8, 4 bytes
    }
}

/// What a member is just now.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant)] // A member of a ring has room for any of them anyway.
pub(super) enum MemberState {
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
    /// The newest that a voter knew.
    pub(super) kept: Kept,
}

impl Candidacy {
    pub(super) fn electorate(&self) -> Roster {
        self.kept.state.everybody()
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
pub(super) struct MemberRecord {
    pub(super) heard_us: Option<u64>,
    pub(super) wants: bool,
    pub(super) leaves: bool,
    pub(super) joins: bool,
    /// Turns of this member in which the other was not heard.
    pub(super) missed: u8,
}
