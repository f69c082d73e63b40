//! History: why a board started, and which faults turned its motors off, kept in flash, so that it survives power.
//!
//! The keys' sector is blank behind the keys. What happens programs the first blank word there; how many words are not blank is a number
//! that no start has twice, since a start is noted before anything is drawn from the generator of random numbers. Nothing is ever erased but
//! by giving the board keys, which begins anew with them.
//!
//! **Limits**: [`FAULTS`] faults a start, and none in the last quarter of the sector, so that starts have room: at least [`STARTS`] of them. Then
//! the number stands. A word that power left half-programmed counts, unless it reads as blank; then nothing had been drawn in that start.

use core::fmt;

use cohold_core::safety::Fault;

use crate::keys;
use crate::status::Stop;
use crate::store::{SECTOR, Word};

/// First word, behind the keys'.
pub const FIRST: u32 = keys::WORDS;
/// Largest number that a start can have.
pub const MOST: u32 = SECTOR - FIRST;
/// Words that are left to starts.
pub const STARTS: u32 = SECTOR / 4;
/// Faults that are kept of one start.
pub const FAULTS: u32 = 8;
/// What is told of it.
const TOLD: usize = 8;

const BLANK: Word = [0xFF; size_of::<Word>()];

/// What happened: a start or a fault, and when.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Entry {
    /// [`Stop`]'s or [`Fault`]'s; 0 of a start that an image of before counted.
    number: u8,
    /// Since the start, ms.
    at_ms: u32,
}

impl Entry {
    fn word(self) -> Word {
        let mut word = [0; size_of::<Word>()];
        word[0] = self.number;
        word[4..8].copy_from_slice(&self.at_ms.to_le_bytes());
        word
    }

    fn of(word: &Word) -> Self {
        let [number, _, _, _, a, b, c, d, ..] = *word;
        Self { number, at_ms: u32::from_le_bytes([a, b, c, d]) }
    }
}

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (Stop::from_number(self.number), Fault::from_number(self.number)) {
            (Some(stop), _) => write!(f, "start: {}", stop.explain()),
            (_, Some(fault)) => {
                write!(f, "fault {} at {}.{:03} s", fault.number(), self.at_ms / 1000, self.at_ms % 1000)
            }
            _ => f.write_str("start"),
        }
    }
}

/// What happened last, and how much did.
#[derive(Clone, Copy, Debug)]
pub struct History {
    /// Words that are not blank: the number of a start that was just noted, from 1.
    pub used: u32,
    faults: u32,
    /// The newest first; none of those that there are not.
    last: [Option<Entry>; TOLD],
}

impl History {
    /// What `read` finds in the sector.
    pub fn open(read: impl Fn(u32) -> Option<Word>) -> Self {
        let used = (FIRST..SECTOR).find(|at| read(*at) == Some(BLANK)).map_or(MOST, |free| free - FIRST);
        let mut last = [None; TOLD];
        for (to, at) in last.iter_mut().zip((FIRST..FIRST + used).rev()) {
            *to = Some(read(at).map_or_else(Entry::default, |word| Entry::of(&word)));
        }
        Self { used, faults: 0, last }
    }

    /// Why the board started. Gives the word to program and where, if there is room; where the flash does not take it, the number may come
    /// again: then there are the other sources of random numbers.
    pub fn start(&mut self, stop: Stop) -> Option<(u32, Word)> {
        self.note(Entry { number: stop as u8, at_ms: 0 }, MOST)
    }

    /// A fault, so many ms after the start; likewise.
    pub fn fault(&mut self, fault: Fault, at_ms: u32) -> Option<(u32, Word)> {
        self.faults += 1;
        let end = if self.faults <= FAULTS { MOST - STARTS } else { 0 };
        self.note(Entry { number: fault.number(), at_ms }, end)
    }

    fn note(&mut self, entry: Entry, end: u32) -> Option<(u32, Word)> {
        self.last.rotate_right(1);
        self.last[0] = Some(entry);
        let place = (self.used < end).then_some((FIRST + self.used, entry.word()));
        self.used += u32::from(place.is_some());
        place
    }
}

/// The newest first.
impl fmt::Display for History {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("newest first")?;
        self.last.iter().flatten().try_for_each(|entry| write!(f, "; {entry}"))
    }
}
