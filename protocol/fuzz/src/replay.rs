//! Sequence numbers in any order: taken once, as a set that forgets nothing says.

use std::collections::HashSet;

use cohold_protocol::link::Error;
use cohold_protocol::replay::{SEQUENCE_LIMIT, Window};

/// Runs one fuzz input, a series of sequence numbers, through a replay window.
pub(super) fn run(bytes: &[u8]) {
    let (mut window, mut taken, mut newest, mut at) = (Window::default(), HashSet::new(), None::<u64>, 0u64);
    for step in bytes.chunks_exact(3) {
        // Small steps either way, and now and then a leap.
        let size = u64::from(u16::from_le_bytes([step[1], step[2]]));
        at = match step[0] % 8 {
            0..=2 => at.wrapping_add(size % 64),
            3..=5 => at.wrapping_sub(size % 300),
            6 => at.wrapping_add(size << (step[0] / 8)),
            _ => SEQUENCE_LIMIT.wrapping_sub(size),
        };
        let wanted = match newest {
            _ if at >= SEQUENCE_LIMIT => Err(Error::BeyondLast),
            Some(newest) if newest > at && newest - at > Window::REACH => Err(Error::TooOld),
            _ if taken.contains(&at) => Err(Error::Replayed),
            _ => Ok(()),
        };
        assert_eq!(window.check(at), wanted);
        assert_eq!(window.take(at), wanted);
        if wanted.is_ok() {
            taken.insert(at);
            newest = newest.max(Some(at));
        }
        assert_eq!(window.newest(), newest);
    }
}
