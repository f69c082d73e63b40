//! What a board logged last: defmt's statements, out of the buffer that a debug probe would read.
//!
//! The buffer holds frames that end in 0, rzcobs-encoded; a frame begins with the number of its statement, which is the
//! address of a symbol that holds the statement's text. Arguments are left out: which statements were reached is what tests ask.

use std::collections::BTreeMap;

use crate::bench::Bench;
use crate::image::Firmware;

/// The control block's first channel: buffer, size and where it is written next, as words behind the block's start.
const CHANNEL: u64 = 24;

/// The statements in a log buffer, oldest first, without their arguments. `peek` gives the words at these addresses.
///
/// # Panics
/// The image has no log.
pub fn read(firmware: &Firmware, mut peek: impl FnMut(Vec<u64>) -> Vec<u32>) -> Vec<String> {
    let channel = firmware.address("_SEGGER_RTT") + CHANNEL;
    let words = peek((1..=3).map(|nth| channel + 4 * nth).collect());
    let [buffer, size, write] = words[..] else { panic!("three words of the log's channel") };
    let words = peek((u64::from(buffer)..).step_by(4).take(size as usize / 4).collect());
    let mut bytes: Vec<u8> = words.into_iter().flat_map(u32::to_le_bytes).collect();
    bytes.rotate_left(write as usize % size as usize);
    bytes.split(|byte| *byte == 0).filter_map(|frame| statement(&firmware.statements, frame)).collect()
}

impl Bench {
    /// What a board (1 or 2) logged last.
    pub fn log(&mut self, firmware: &Firmware, number: usize) -> Vec<String> {
        read(firmware, |addresses| self.peek_now(number, addresses))
    }
}

/// The text of a frame's statement; `None` if the frame is not whole.
fn statement(statements: &BTreeMap<u16, String>, frame: &[u8]) -> Option<String> {
    let frame = decode(frame)?;
    let number = u16::from_le_bytes(*frame.first_chunk()?);
    statements.get(&number).cloned()
}

/// rzcobs, from the end: a byte says which of the seven before it are zeros that were left out, or how many are none.
fn decode(frame: &[u8]) -> Option<Vec<u8>> {
    let (mut decoded, mut bytes) = (Vec::new(), frame.iter().rev().copied());
    while let Some(mark) = bytes.next() {
        match mark {
            0 => return None,
            1..=0x7F => {
                for bit in (0..7).rev() {
                    decoded.push(if mark >> bit & 1 == 0 { bytes.next()? } else { 0 });
                }
            }
            0x80..=0xFE => {
                decoded.push(0);
                for _ in 0..(mark & 0x7F) + 7 {
                    decoded.push(bytes.next()?);
                }
            }
            0xFF => {
                for _ in 0..134 {
                    decoded.push(bytes.next()?);
                }
            }
        }
    }
    decoded.reverse();
    Some(decoded)
}
