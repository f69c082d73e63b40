//! Random numbers from the chip's own source, for the links' challenges.
//!
//! The generator checks its noise source and its clock and says so; what it gave since the last check that failed is not
//! used. After a failure it is started anew, three times at the most. A source that does not recover gives `None`, and a
//! board without randomness talks to nobody: nothing here waits for ever.

use embassy_stm32::{Peri, pac, peripherals::RNG, rcc};

/// Looks at the generator until a word must be there: 1 µs for a word, 10 µs for the first.
const LOOKS: u32 = 20_000;

pub(crate) fn start(_: Peri<'static, RNG>) {
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

/// 32 random bytes; `None` if the source has failed. For the tasks of one executor.
pub(crate) fn draw() -> Option<[u8; 32]> {
    for _ in 0..3 {
        if let Some(words) = words() {
            let mut bytes = [0; 32];
            for (to, word) in bytes.chunks_exact_mut(4).zip(words) {
                to.copy_from_slice(&word.to_le_bytes());
            }
            return Some(bytes);
        }
        restart();
    }
    None
}
