//! Any bytes as a recording: no panic, no more numbers than bytes can hold, and nothing of it that a merge falls over.

use haptic_live::recording::file::{Recording, read_from};
use haptic_live::recording::merge::{both, merge};

/// How every recording begins.
const BEGINS: &[u8] = b"\x89MCAP0\r\n";

fn take(bytes: &[u8]) -> Option<Recording> {
    let recording = read_from(bytes, bytes.len() as u64).ok()?;
    let mut numbers = 0;
    for rows in &recording.channels {
        for name in &rows.names {
            assert_eq!(rows.column(name).map(<[f64]>::len), Some(rows.len()));
        }
        assert_eq!(rows.table().len(), rows.len());
        numbers += rows.names.len() * rows.len();
    }
    assert!(8 * numbers <= bytes.len(), "{numbers} numbers in {} bytes", bytes.len());
    if let Some(cut) = recording.cut {
        assert_eq!(cut.whole + cut.rest, bytes.len() as u64);
    }
    Some(recording)
}

/// Runs one fuzz input, as it is and behind the right beginning.
pub(super) fn run(bytes: &[u8]) {
    for recording in [take(bytes), take(&[BEGINS, bytes].concat())].into_iter().flatten() {
        let _ = (both(&recording), merge(&recording, &recording));
    }
}
