//! Collaborative environments on trial: many seeded runs of lock and token ring, with a checker that knows what is true.
//!
//! In the first part of a run everything goes wrong: messages are lost, doubled, overtaken, held back for several leases, peers
//! crash and come back from their records, the network falls apart. Then it heals, and the clock of progress starts: every
//! user who wants to must have published within the bound that the protocol states.

mod history;
mod lock;
mod ring;
mod trial;
mod user;
mod world;

use rayon::prelude::*;

use crate::roles::collaborative::Lease;

pub use trial::MOST_USERS;
pub use trial::{Mistake, Scheme, Trial, Verdict};

/// Lease of a lock and of the token: 300 ms.
fn lease() -> Lease {
    // In range, or nothing here would work at all.
    Lease::new(300_000).unwrap_or_else(|error| panic!("{error}"))
}

/// Many runs, in parallel; the same on any number of threads.
pub fn campaign(trial: &Trial, runs: u64, done: &(impl Fn() + Sync)) -> Verdict {
    let one = |run| {
        let verdict = world::run(&Trial { seed: trial.seed.wrapping_add(run), ..*trial });
        done();
        verdict
    };
    (0..runs).into_par_iter().map(one).reduce(Verdict::default, Verdict::and)
}
