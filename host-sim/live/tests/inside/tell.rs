use std::time::Duration;

use super::*;

/// Somebody who cuts a path 32 times a second for a minute causes 79 lines, and each gap says how many are missing.
#[test]
fn whoever_disturbs_the_network_fills_no_terminal() {
    let start = Instant::now();
    let mut limiter = Limiter::new(start);
    let at = |cut: u32| start + cut * Duration::from_micros(31_250);
    let shown: Vec<String> = (0..1920).filter_map(|cut| limiter.shown(at(cut), format!("cut {cut}"))).collect();
    assert_eq!(shown.len(), 20 + 59, "{shown:?}");
    assert_eq!(shown[19..21], ["cut 19", "cut 32 (12 lines before it are left out)"]);
    // A minute later nothing is left out.
    assert_eq!(limiter.shown(at(3840), "a".into()).as_deref(), Some("a (31 lines before it are left out)"));
    assert_eq!(limiter.shown(at(3840), "b".into()).as_deref(), Some("b"));
}
