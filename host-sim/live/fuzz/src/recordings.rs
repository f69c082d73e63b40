//! Any bytes as a recording: no panic, no more numbers than bytes can hold, and nothing of it that a merge falls over.

use cohold_live::recording::file::{Recording, read_from};
use cohold_live::recording::merge::{both, merge};

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

/// The same bytes, in which no chunk has a checksum: what is changed in it is read, too.
fn unchecked(bytes: &[u8]) -> Vec<u8> {
    const CHUNK: u8 = 6;
    let (mut bytes, mut at) = (bytes.to_vec(), BEGINS.len());
    while let Some(head) = bytes.get(at..at + 9) {
        let (opcode, length) = (head[0], u64::from_le_bytes(head[1..].try_into().expect("eight bytes")));
        if opcode == CHUNK
            && let Some(checksum) = bytes.get_mut(at + 9 + 24..at + 9 + 28)
        {
            checksum.fill(0);
        }
        let Some(next) = usize::try_from(length).ok().and_then(|length| (at + 9).checked_add(length)) else { break };
        at = next;
    }
    bytes
}

/// Runs one fuzz input, as it is and behind the right beginning.
pub(super) fn run(bytes: &[u8]) {
    let begun = [BEGINS, bytes].concat();
    for recording in [take(bytes), take(&unchecked(bytes)), take(&begun)].into_iter().flatten() {
        let mut other = recording.clone();
        for rows in &mut other.channels {
            rows.topic = rows.topic.replace("peer_1", "peer_2");
        }
        let _ = both(&recording);
        for hub in [None, Some(&recording)] {
            let _ = merge(&recording, &other, hub).map(|merged| merged.table.len());
        }
    }
}
