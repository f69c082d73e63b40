//! A hundred thousand forged datagrams a second: the session stays, nothing forged changes anything, flow is whole again.
//!
//! Judged by the peers' state and their own time, so that a machine that is busy with other things finds the same.

use cohold_sim::{Laws, scenes};

mod trial;

#[test]
fn a_flood_of_forged_datagrams_changes_nothing() {
    let scene = scenes::load(Laws::built_in(), "paper-5.2-passive-wave-16ms").expect("a built-in scene");
    let (sent, peers) = trial::run(&scene, 1e5, 1.0).expect("they meet");
    // Every kind was there, however many a busy machine got out.
    assert!(sent.iter().all(|count| *count > 100), "{sent:?}");
    for peer in &peers {
        assert_eq!((peer.forged_taken, peer.states_changed), (0, 0), "{peer:?}");
        assert_eq!(peer.forged_arrived, peer.forged_refused + peer.hellos_answered, "{peer:?}");
        assert!(peer.forged_arrived > 1000 && peer.states_compared > 10, "{peer:?}");
        assert!(peer.session_stayed && peer.engaged, "{peer:?}");
        assert!(peer.flow_through > 0.0 && peer.whole_after_ms <= 100, "{peer:?}");
    }
}
