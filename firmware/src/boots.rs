//! Boots: how often the board has started since it was given its keys, kept in flash.
//!
//! The keys' sector is blank behind the keys. Every start programs the first blank word there, before anything is drawn from the
//! generator of random numbers; how many words are not blank is the number of the start. Nothing is ever erased but by giving the
//! board keys, which begins the count anew with them.
//!
//! **Limits**: after [`MOST`] starts, 11 years of one a day, the number stands. A word that power left half-programmed counts,
//! unless it reads as blank; then nothing had been drawn in that start.

use crate::keys;
use crate::store::{Broken, SECTOR, Word};

/// First word of the count, behind the keys'.
pub const FIRST: u32 = keys::WORDS;
/// Largest number of starts that can be counted.
pub const MOST: u32 = SECTOR - FIRST;

/// Counts this start and gives its number, from 1. Where the flash does not take the word, the number may come again.
pub fn count(read: impl Fn(u32) -> Option<Word>, program: impl FnOnce(u32, &Word) -> Result<(), Broken>) -> u32 {
    let blank = |at: &u32| read(*at) == Some([0xFF; size_of::<Word>()]);
    let Some(free) = (FIRST..SECTOR).find(blank) else { return MOST };
    // Another start, or none, is what it is then; the other sources remain.
    let _ = program(free, &[0; size_of::<Word>()]);
    free - FIRST + 1
}
