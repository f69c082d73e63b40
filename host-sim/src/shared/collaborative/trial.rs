//! A trial: what is tried, on how many users, with which mistake put in on purpose.

use haptic_core::names::Choice;
use serde::Serialize;

/// Who says whose turn it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// A central server.
    Lock,
    /// A token that goes round.
    Ring,
}

/// A mistake put in on purpose, outside of the code that is tried: the checker must find it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mistake {
    /// One peer's clock counts a quarter of the time: beyond what a lease allows.
    SlowClock,
    /// Records are not there after a crash.
    Amnesia,
    /// A release counts whatever its fence says, as if there were no fences (lock only).
    NoFence,
    /// One vote for a new token counts for everybody's (ring only).
    NoMajority,
}

impl Choice for Mistake {
    const NAMES: &'static [&'static str] = &["slow-clock", "amnesia", "no-fence", "no-majority"];
    const ALL: &'static [Self] = &[Self::SlowClock, Self::Amnesia, Self::NoFence, Self::NoMajority];
}

impl Mistake {
    /// Whether the scheme can make it.
    pub fn fits(self, scheme: Scheme) -> bool {
        match self {
            Self::SlowClock | Self::Amnesia => true,
            Self::NoFence => scheme == Scheme::Lock,
            Self::NoMajority => scheme == Scheme::Ring,
        }
    }
}

/// What to try.
#[derive(Clone, Copy, Debug)]
pub struct Trial {
    /// Which scheme.
    pub scheme: Scheme,
    /// Users: 2 to [`MOST_USERS`].
    pub users: u8,
    /// Seed of the first run; the others follow.
    pub seed: u64,
    /// Put in on purpose.
    pub mistake: Option<Mistake>,
}

/// Users that a trial can have.
pub const MOST_USERS: u8 = 8;
