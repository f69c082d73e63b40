//! A hundred thousand forged datagrams a second: the session stays, nothing forged changes anything, flow is whole again.
//!
//! Judged by the peers' state and their own time, so that a machine that is busy with other things finds the same.

use haptic_sim::scenes;
use host_sim::trials::flood::{Options, run};

#[test]
fn a_flood_of_forged_datagrams_changes_nothing() {
    let scene = scenes::load("paper-5.2-passive-wave-16ms").expect("a built-in scene");
    let report = run(&scene, &Options { rate_per_s: 1e5, seconds: 1.0 }).expect("two sockets on loopback");
    // Every kind was there; how many a busy machine got out is for the report.
    assert!(report.sent.iter().all(|(_, count)| *count > 100), "{report:?}");
    for peer in &report.peers {
        assert_eq!((peer.forged_taken, peer.states_changed), (0, 0), "{report:?}");
        assert_eq!(peer.forged_arrived, peer.forged_refused + peer.hellos_answered, "{report:?}");
        assert!(peer.forged_arrived > 1000 && peer.states_compared > 10, "{report:?}");
        assert!(peer.session_stayed && peer.engaged, "{report:?}");
        assert!(peer.flow_through > 0.0 && peer.whole_after_ms <= 100, "{report:?}");
    }
}
