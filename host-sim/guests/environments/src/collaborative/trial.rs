//! A trial: what is tried, on how many users, with which mistake put in on purpose; and what it came to.

use serde::Serialize;

/// Who says whose turn it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// A lock that a central server grants.
    Lock,
    /// A token that goes round the members.
    Ring,
}

cohold_sim::choices! {
    /// A mistake put in on purpose, outside of the code that is tried: the checker must find it.
    Mistake {
        "slow-clock" => SlowClock, "One peer's clock counts a quarter of the time: beyond what a lease allows.";
        "amnesia" => Amnesia, "Records are not there after a crash.";
        "no-fence" => NoFence, "A release counts whatever its fence says, as if there were no fences (lock only).";
        "no-majority" => NoMajority, "One vote for a new token counts for everybody's (ring only).";
    }
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

/// Scheme, users and seeds of a trial.
#[derive(Clone, Copy, Debug)]
pub struct Trial {
    /// The scheme that is tried.
    pub scheme: Scheme,
    /// Number of users, 2 to 8.
    pub users: u8,
    /// Seed of the first run; the others follow.
    pub seed: u64,
    /// Put in on purpose.
    pub mistake: Option<Mistake>,
}

/// Users that a trial can have.
pub const MOST_USERS: u8 = 8;

/// What many runs came to.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Verdict {
    /// Number of runs that were made.
    pub runs: u64,
    /// Runs with two owners at one instant.
    pub two_owners: u64,
    /// Runs with a lost update: the history is not one branch.
    pub lost_update: u64,
    /// Runs in which a user who wanted to did not publish in time.
    pub no_progress: u64,
    /// Seed of the first run that failed, and how.
    pub first_failure: Option<(u64, String)>,
    /// Updates that their authors were notified are published.
    pub published: u64,
    /// Rights to edit that ended before their owner had finished.
    pub interrupted: u64,
    /// Peers that went down for a while.
    pub crashes: u64,
    /// Number of messages sent.
    pub messages: u64,
    /// Messages lost, by the network or because nobody was there.
    pub lost: u64,
    /// Longest wait for a publication after the end of all trouble, ms.
    pub longest_wait_ms: f64,
    /// What the protocol states as its bound, ms.
    pub wait_bound_ms: f64,
}

impl Verdict {
    pub(super) fn and(self, other: Self) -> Self {
        let first_failure = match (self.first_failure, other.first_failure) {
            (Some(one), Some(two)) => Some(if one.0 <= two.0 { one } else { two }),
            (one, two) => one.or(two),
        };
        Self {
            runs: self.runs + other.runs,
            two_owners: self.two_owners + other.two_owners,
            lost_update: self.lost_update + other.lost_update,
            no_progress: self.no_progress + other.no_progress,
            first_failure,
            published: self.published + other.published,
            interrupted: self.interrupted + other.interrupted,
            crashes: self.crashes + other.crashes,
            messages: self.messages + other.messages,
            lost: self.lost + other.lost,
            longest_wait_ms: self.longest_wait_ms.max(other.longest_wait_ms),
            wait_bound_ms: self.wait_bound_ms.max(other.wait_bound_ms),
        }
    }
}
