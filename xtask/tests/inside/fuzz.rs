//! Tests of `src/fuzz.rs` from inside.

use super::*;

#[test]
fn options_are_checked_before_anything_is_built() {
    let asked = |words: &[&str]| crate::read("fuzz", words).and_then(|given| plan(&given));
    assert_eq!(
        asked(&["--seconds", "5", "--target", "replay"]).expect("good options"),
        (vec![("protocol/fuzz", "replay")], 5)
    );
    assert_eq!(asked(&[]).map(|(targets, seconds)| (targets.len(), seconds)).ok(), Some((18, 60)));
    for (bad, allowed) in [
        (&["--seconds", "0"][..], "from 1 to 86400"),
        (&["--seconds"], "--seconds needs a value"),
        (&["--target", "wires"], "one of wire, replay, link, session"),
        (&["--fast"], "there is no option --fast"),
    ] {
        let said = asked(bad).err().map(|failure| failure.to_string()).unwrap_or_default();
        assert!(said.contains(allowed), "{said}");
    }
}
