//! Tests of `src/fuzz.rs` from inside.

use super::*;

#[test]
fn options_are_checked_before_anything_is_built() {
    let plan = Plan::parse(&["--seconds", "5", "--target", "replay"]).expect("good options");
    assert_eq!((plan.targets, plan.seconds), (vec!["replay"], 5));
    assert_eq!(Plan::parse(&[]).map(|plan| (plan.targets.len(), plan.seconds)).ok(), Some((13, 60)));
    for (bad, allowed) in [
        (&["--seconds", "0"][..], "from 1 to 86400"),
        (&["--seconds"], "from 1 to 86400"),
        (&["--target", "wires"], "one of wire, records, replay, link, session"),
        (&["--fast"], "there is no option --fast"),
    ] {
        let said = Plan::parse(bad).err().map(|failure| failure.to_string()).unwrap_or_default();
        assert!(said.contains(allowed), "{said}");
    }
}
