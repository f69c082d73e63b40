//! Keys from a source of randomness that repeats itself.

use cohold_live::key_file::hedged;
use cohold_protocol::key::Key;

#[test]
fn a_source_that_repeats_itself_repeats_nothing_here() {
    let drawn: std::collections::HashSet<_> = (0..1_000).map(|_| hedged([0xA5; Key::LEN])).collect();
    assert_eq!(drawn.len(), 1_000);
}
