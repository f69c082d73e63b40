//! Random numbers from the chip's own source, for the links' ephemerals and challenges.
//!
//! What the source gives is never used by itself, but mixed with what differs from start to start ([`firmware_parts::hedge`]).
//!
//! The generator checks its noise source and its clock and says so; what it gave since the last check that failed is not
//! used. After a failure it is started anew, three times at the most. A source that does not recover gives `None`, and a
//! board without randomness talks to nobody: nothing here waits for ever.

use core::sync::atomic::{AtomicU32, Ordering};

use cohold_protocol::key::Key;
use embassy_stm32::{Peri, pac, peripherals::RNG, rcc};
use embassy_time::Instant;
use firmware_parts::hedge::Sources;

use super::Number;

/// Number of this start.
static BOOT: AtomicU32 = AtomicU32::new(0);
/// Draws in this start.
static DRAWN: AtomicU32 = AtomicU32::new(0);

/// Looks at the generator until a word must be there: 1 µs for a word, 10 µs for the first.
const LOOKS: u32 = 20_000;

/// Starts the source, in the start of the board with this number.
pub(crate) fn start(_: Peri<'static, RNG>, boot: u32) {
    BOOT.store(boot, Ordering::Relaxed);
    rcc::enable_and_reset::<RNG>();
    restart();
}

fn restart() {
    pac::RNG.cr().write(|w| w.set_rngen(false));
    // Zero clears both flags; one has no effect.
    pac::RNG.sr().write(|w| w.0 = 0);
    pac::RNG.cr().write(|w| w.set_rngen(true));
}

/// A word, or why there is none: the source failed.
fn word() -> Option<u32> {
    for _ in 0..LOOKS {
        let status = pac::RNG.sr().read();
        if status.seis() || status.ceis() || status.secs() || status.cecs() {
            return None;
        }
        if status.drdy() {
            // Zero means that the source failed between the two reads (RM0433 §34.7.3).
            return Some(pac::RNG.dr().read()).filter(|word| *word != 0);
        }
    }
    None
}

/// Fresh words, of which no two in a row are the same: that would be a source that is stuck.
fn words() -> Option<[u32; 8]> {
    let mut last = word()?;
    let mut words = [0; 8];
    for to in &mut words {
        let next = word().filter(|next| *next != last)?;
        (*to, last) = (next, next);
    }
    Some(words)
}

/// 32 random bytes for board `number`, whose keys make this seed; `None` if the source has failed. For the tasks of one executor.
pub(crate) fn draw(seed: &Key, number: Number) -> Option<[u8; 32]> {
    for _ in 0..3 {
        if let Some(words) = words() {
            let mut noise = [0; 32];
            for (to, word) in noise.chunks_exact_mut(4).zip(words) {
                to.copy_from_slice(&word.to_le_bytes());
            }
            let (board, boot) = (number as u8, BOOT.load(Ordering::Relaxed));
            let (draw, uptime_us) = (DRAWN.fetch_add(1, Ordering::Relaxed), Instant::now().as_micros());
            return Some(Sources { noise, board, boot, draw, uptime_us }.mixed(seed));
        }
        restart();
    }
    None
}
