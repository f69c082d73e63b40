//! Tests of `src/endpoint.rs` from inside.

use super::*;

/// At 1 kHz the 2³²nd tick is due after 49.7 days, and those after it each a period later.
#[test]
fn ticks_go_on_after_the_first_four_billion() {
    let mut ticker = Ticker::new(Duration::from_millis(1));
    for ticks in [u64::from(u32::MAX), 1 << 32, (1 << 32) + 5, 10 << 32] {
        ticker.kept.ticks = ticks;
        assert_eq!(ticker.deadline() - ticker.start, Duration::from_millis(ticks));
    }
}
