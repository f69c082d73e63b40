//! Collaborative environments on trial: many seeded runs of lock and token ring, with a checker that knows what is true.
//!
//! | module | holds |
//! |---|---|
//! | [`history`] | the checker: who built on what, what was promised to whom |
//! | [`world`] | one run: peers with clocks of their own, a bad network, crashes, partitions |
//! | [`user`] | a user who comes, edits and goes |
//! | [`lock`], [`ring`] | the peers of either scheme as the world sees them |
//!
//! In the first part of a run everything goes wrong: messages are lost, doubled, overtaken, held back for several leases, peers
//! crash and come back from their records, the network falls apart. Then it heals, and the clock of progress starts: every
//! user who wants to must have published within the bound that the protocol states.

use std::rc::Rc;

use rayon::prelude::*;
use serde::Serialize;

pub mod history;
pub mod lock;
pub mod ring;
mod trial;
pub mod user;
pub mod world;

pub use trial::{MOST_USERS, Mistake, Scheme, Trial};
use world::{Run, Trouble};

/// What many runs came to.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Verdict {
    /// Runs.
    pub runs: u64,
    /// Runs with two owners at one instant.
    pub two_owners: u64,
    /// Runs with a lost update.
    pub lost_update: u64,
    /// Runs in which a user who wanted to did not publish in time.
    pub no_progress: u64,
    /// Seed of the first run that failed, and how.
    pub first_failure: Option<(u64, String)>,
    /// Updates that their authors were told are published.
    pub published: u64,
    /// Rights to edit that ended before their owner had finished.
    pub interrupted: u64,
    /// Crashes.
    pub crashes: u64,
    /// Messages sent.
    pub messages: u64,
    /// Messages lost, by the network or because nobody was there.
    pub lost: u64,
    /// Longest wait for a publication after the end of all trouble, ms.
    pub longest_wait_ms: f64,
    /// What the protocol states as its bound, ms.
    pub wait_bound_ms: f64,
}

impl Verdict {
    fn of(seed: u64, run: Run) -> Self {
        let is = |trouble| u64::from(run.trouble.as_ref().is_some_and(|(kind, _)| *kind == trouble));
        Self {
            runs: 1,
            two_owners: is(Trouble::TwoOwners),
            lost_update: is(Trouble::LostUpdate),
            no_progress: is(Trouble::NoProgress),
            published: run.published,
            interrupted: run.interrupted,
            crashes: run.crashes,
            messages: run.messages,
            lost: run.lost,
            longest_wait_ms: run.longest_wait_us as f64 * 1e-3,
            wait_bound_ms: run.wait_bound_us as f64 * 1e-3,
            first_failure: run.trouble.map(|(_, what)| (seed, what)),
        }
    }

    fn and(self, other: Self) -> Self {
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

    /// Nothing went wrong.
    pub fn is_clean(&self) -> bool {
        self.first_failure.is_none()
    }
}

/// Many runs, in parallel; the same on any number of threads.
pub fn campaign(trial: &Trial, runs: u64, done: &(impl Fn() + Sync)) -> Verdict {
    (0..runs)
        .into_par_iter()
        .map(|run| {
            let seed = trial.seed.wrapping_add(run);
            let verdict = Verdict::of(seed, one(&Trial { seed, ..*trial }));
            done();
            verdict
        })
        .reduce(Verdict::default, Verdict::and)
}

/// One run.
pub fn one(trial: &Trial) -> Run {
    let history = Rc::default();
    match trial.scheme {
        Scheme::Lock => world::run(trial, &history, lock::peers(trial, &history)),
        Scheme::Ring => world::run(trial, &history, ring::peers(trial, &history)),
    }
}
