//! Tests of `src/licences.rs` from inside.

use super::wrong;

#[test]
fn one_of_several_is_enough_and_each_of_all_is_needed() {
    let allowed = ["MIT", "OFL-1.1"];
    for good in ["MIT", "MIT OR GPL-3.0-only", "GPL-3.0-only/MIT", "(MIT OR GPL-3.0-only) AND OFL-1.1"] {
        assert_eq!(wrong("one v1.0.0", good, &allowed), None);
    }
    for bad in ["", "GPL-3.0-only", "MIT AND GPL-3.0-only"] {
        assert!(wrong("one v1.0.0", bad, &allowed).is_some_and(|why| why.contains("does not allow")), "{bad}");
    }
    for from in ["one v1.0.0 (https://example.org/one#abc)", "one v1.0.0 (/elsewhere/one)"] {
        assert!(wrong(from, "MIT", &allowed).is_some_and(|why| why.contains("registry")));
    }
    assert_eq!(wrong("one v1.0.0 (proc-macro)", "MIT", &allowed), None);
}
