//! The recorder: what the last ticks before a fault did, whether anybody recorded or not.
//!
//! A record of each shared axis goes to a [`Reel`] after every tick, round and round. A fault that turns the motors off hands the reel over: it
//! stands still, and the next ticks go to another. Reels lie in memory that start-up leaves alone, so that they survive a reset: [`after`] finds the
//! one that tells of it. Power, and a supply that was too low, end them.

use cohold_protocol::record::Record;

use crate::image::SHARED;
use crate::status::Stop;

/// Ticks on a reel.
pub const TICKS: usize = 256;
const RECORDS: usize = TICKS * SHARED;
/// Tells a reel from what memory holds at power-on.
const MAGIC: u32 = 0x5265_656C;

/// The records of the last [`TICKS`] ticks.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Reel {
    magic: u32,
    /// How many were begun before it since power came on.
    number: u32,
    /// It was handed over at a fault: 1.
    stands: u32,
    /// Where the next record goes.
    next: u32,
    /// All of it was written to: 1.
    full: u32,
    records: [Record; RECORDS],
}

impl Reel {
    /// One without a record.
    pub const fn empty() -> Self {
        Self { magic: MAGIC, number: 0, stands: 0, next: 0, full: 0, records: [Record::EMPTY; RECORDS] }
    }

    /// Forgets what was on it.
    #[inline]
    pub fn begin(&mut self, number: u32) {
        (self.magic, self.number, self.stands, self.next, self.full) = (MAGIC, number, 0, 0, 0);
    }

    /// Writes a record over the oldest.
    pub fn write(&mut self, record: &Record) {
        let at = self.next as usize % RECORDS;
        let is_last = at == RECORDS - 1;
        self.next = if is_last { 0 } else { at as u32 + 1 };
        self.full |= u32::from(is_last);
        self.records[at] = *record;
    }

    /// It stands still from now on; gives the number of the next.
    #[inline]
    pub fn stand(&mut self) -> u32 {
        self.stands = 1;
        self.number.wrapping_add(1)
    }

    /// How many records are on it.
    pub fn count(&self) -> usize {
        if self.full == 1 { RECORDS } else { self.next as usize % RECORDS }
    }

    /// The oldest record is number 0.
    pub fn get(&self, number: usize) -> Option<&Record> {
        let first = if self.full == 1 { self.next as usize } else { 0 };
        (number < self.count()).then(|| &self.records[(first + number) % RECORDS])
    }
}

/// After a start: the reel to be written next, the one to be shown, and another.
pub fn after(stop: Stop, mut reels: [&'static mut Reel; 3]) -> [&'static mut Reel; 3] {
    if stop.lost_memory() {
        reels.iter_mut().for_each(|reel| **reel = Reel::empty());
    }
    // Of a program that failed the newest tells, of another start the newest that stands.
    let tells = |reel: &Reel| {
        let told = reel.magic == MAGIC && (reel.stands == 1 || stop.latches());
        if told { reel.number.wrapping_add(1) } else { 0 }
    };
    let newest = (0..3).max_by_key(|at| tells(reels[*at])).unwrap_or(0);
    reels.swap(1, newest);
    let [next, shown, spare] = &mut reels;
    if tells(shown) == 0 {
        shown.begin(0);
    }
    spare.begin(0);
    next.begin(shown.number.wrapping_add(1));
    reels
}
