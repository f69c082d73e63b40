//! A hundred thousand forged datagrams a second: the session stays, nothing forged changes anything, flow is whole again.
//!
//! Judged by the peers' state and their own time, so that a machine that is busy with other things finds the same.

use crate::program::{host_sim, report};

#[test]
fn a_flood_of_forged_datagrams_changes_nothing() {
    let scene = ["network", "flood", "--json", "--scene", "paper-5.2-passive-wave-16ms"];
    let flood = host_sim(&[&scene[..], &["--rate", "1e5", "--seconds", "1"]].concat()).spawn().expect("host-sim runs");
    let report = report(flood);
    // Every kind was there; how many a busy machine got out is for the report.
    let sent = report["sent"].as_array().expect("kinds");
    assert!(sent.len() == 5 && sent.iter().all(|kind| kind[1].as_u64() > Some(100)), "{report}");
    for peer in report["peers"].as_array().expect("two peers") {
        let count = |name: &str| peer[name].as_u64().unwrap_or_else(|| panic!("{name} in {report}"));
        assert_eq!((count("forged_taken"), count("states_changed")), (0, 0), "{report}");
        assert_eq!(count("forged_arrived"), count("forged_refused") + count("hellos_answered"), "{report}");
        assert!(count("forged_arrived") > 1000 && count("states_compared") > 10, "{report}");
        assert!(peer["session_stayed"] == true && peer["engaged"] == true, "{report}");
        assert!(peer["flow_through"].as_f64() > Some(0.0) && count("whole_after_ms") <= 100, "{report}");
    }
}
