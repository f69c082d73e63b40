//! Lock and token ring against loss, reorder, duplication, late messages, crashes and partitions; and against mistakes that
//! the checker must find. `cohold shared collaborate` runs the same, 10,000 times and more.

use cohold_environments::collaborative::{Mistake, Scheme, Trial, Verdict, campaign};

fn run(scheme: Scheme, users: u8, runs: u64, mistake: Option<Mistake>) -> Verdict {
    campaign(&Trial { scheme, users, seed: 1, mistake }, runs, &|| ())
}

#[test]
fn never_two_owners_never_a_lost_update_always_progress() {
    for scheme in [Scheme::Lock, Scheme::Ring] {
        for users in [2, 3, 5, 8] {
            let verdict = run(scheme, users, 250, None);
            assert!(verdict.first_failure.is_none(), "{scheme:?}, {users} users: {verdict:?}");
            // Not because nothing happened.
            let lively = verdict.published > 5 * verdict.runs && verdict.crashes > 200 && verdict.interrupted > 10;
            assert!(lively && verdict.lost * 10 > verdict.messages, "{scheme:?}, {users} users: {verdict:?}");
            assert!(verdict.longest_wait_ms <= verdict.wait_bound_ms, "{scheme:?}, {users} users: {verdict:?}");
        }
    }
}

#[test]
fn the_checker_finds_clocks_beyond_what_a_lease_allows() {
    assert!(run(Scheme::Lock, 3, 100, Some(Mistake::SlowClock)).two_owners > 0);
    assert!(run(Scheme::Ring, 3, 1000, Some(Mistake::SlowClock)).two_owners > 0);
}

#[test]
fn the_checker_finds_peers_that_forget() {
    for scheme in [Scheme::Lock, Scheme::Ring] {
        assert!(run(scheme, 3, 50, Some(Mistake::Amnesia)).lost_update > 0, "{scheme:?}");
    }
}

#[test]
fn the_checker_finds_a_missing_fence_and_a_missing_majority() {
    let verdict = run(Scheme::Lock, 3, 50, Some(Mistake::NoFence));
    assert!(verdict.two_owners > 0 && verdict.lost_update > 0, "{verdict:?}");
    let verdict = run(Scheme::Ring, 5, 200, Some(Mistake::NoMajority));
    assert!(verdict.lost_update > 0, "{verdict:?}");
}

#[test]
fn the_same_seed_is_the_same_run() {
    for scheme in [Scheme::Lock, Scheme::Ring] {
        let [one, two] = [(); 2].map(|()| serde_json::to_string(&run(scheme, 5, 20, None)).unwrap());
        assert_eq!(one, two);
    }
}
