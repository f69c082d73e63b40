//! Times of tick and current loop on the chip: how late it began, how long it took, how far two were apart, as histograms.
//!
//! The tick leaves four words behind ([`Took`]) and the interrupt below it counts them here, so that counting costs the tick nothing. One
//! writer, any readers, no lock: a reader may see a tick in one word and not yet in another. In cycles of the core's clock, since the
//! start of the board; a count wraps after 49 days of ticks.

use core::fmt;

use crate::record::{OVERRUN, PARTED, RECEIVED, SENT};
use crate::signals::Word;

/// What one tick left about itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Took {
    /// Number of the tick.
    pub tick: u32,
    /// Flags of what the tick did, as in a record ([`crate::record`]).
    pub flags: u8,
    /// Cycles from when it was due to when it began.
    pub delay: u32,
    /// When it began, by the counter of cycles.
    pub began: u32,
    /// When it ended, by the counter of cycles.
    pub ended: u32,
}

/// How many of each power of two, and the longest.
#[derive(Debug)]
pub struct Histogram {
    counts: [Word<u32>; Self::BINS],
    most: Word<u32>,
    tick: Word<u32>,
    flags: Word<u32>,
}

impl Histogram {
    /// Bin 0 is 0 and 1 cycles, bin `k` from `2^k` on, the last whatever is longer.
    pub const BINS: usize = 16;

    const fn new() -> Self {
        Self {
            counts: [const { Word::zero() }; Self::BINS],
            most: Word::zero(),
            tick: Word::zero(),
            flags: Word::zero(),
        }
    }

    fn see(&self, cycles: u32, took: &Took) {
        let bin = (cycles | 1).ilog2() as usize;
        let [.., last] = &self.counts;
        self.counts.get(bin).unwrap_or(last).count();
        if cycles > self.most.get() {
            self.most.set(cycles);
            self.tick.set(took.tick);
            self.flags.set(took.flags.into());
        }
    }

    /// How many there were of each.
    pub fn counts(&self) -> [u32; Self::BINS] {
        self.counts.each_ref().map(Word::get)
    }

    /// The longest time counted, cycles.
    pub fn most(&self) -> u32 {
        self.most.get()
    }
}

/// The longest, in which tick, and what that did; then `from:how many` of every bin that is not empty.
impl fmt::Display for Histogram {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "most {} in tick {}", self.most.get(), self.tick.get())?;
        let did = [(SENT, "sent"), (RECEIVED, "received"), (PARTED, "parted"), (OVERRUN, "late")];
        for (_, what) in did.iter().filter(|(flag, _)| self.flags.get() & u32::from(*flag) != 0) {
            write!(f, " {what}")?;
        }
        f.write_str("; from:ticks")?;
        for (bin, count) in self.counts().iter().enumerate().filter(|(_, count)| **count > 0) {
            write!(f, " {}:{count}", if bin == 0 { 0 } else { 1_u32 << bin })?;
        }
        Ok(())
    }
}

/// Cycles that an interrupt had.
#[derive(Debug)]
pub struct Load {
    sum: Word<u32>,
    second: Word<u32>,
}

impl Load {
    /// A load of which nothing is counted.
    pub const fn none() -> Self {
        Self { sum: Word::zero(), second: Word::zero() }
    }

    /// Adds this many cycles.
    pub fn see(&self, cycles: u32) {
        self.sum.set(self.sum.get().wrapping_add(cycles));
    }

    /// A second is over.
    pub fn second(&self) {
        self.second.set(self.sum.get());
        self.sum.set(0);
    }

    /// Hundredths of a percent of a processor with so many cycles a second, in the last second that is over.
    pub fn share(&self, cycles_per_s: u32) -> u32 {
        (u64::from(self.second.get()) * 10_000 / u64::from(cycles_per_s.max(1))) as u32
    }
}

/// The three times of a tick.
#[derive(Debug)]
pub struct Times {
    /// From when it was due to when it began.
    pub delay: Histogram,
    /// From when it began to when it ended.
    pub duration: Histogram,
    /// How far from a period the beginnings of two in a row were apart.
    pub spacing: Histogram,
    last: Word<u32>,
    began: Word<u32>,
}

impl Times {
    /// Times of which nothing is counted.
    pub const fn none() -> Self {
        let [delay, duration, spacing] = [const { Histogram::new() }; 3];
        Self { delay, duration, spacing, last: Word::zero(), began: Word::zero() }
    }

    /// Takes in a tick; one that was missed makes no spacing. `period` in cycles.
    pub fn see(&self, took: &Took, period: u32) {
        // The first tick is number 1, and nothing is known of the one before it.
        let follows = took.tick > 1 && took.tick.wrapping_sub(self.last.get()) == 1;
        self.last.set(took.tick);
        self.see_run(took, follows, period);
    }

    /// Takes in what runs more often than ticks do, in a tick; `follows`: it ran a period ago, and that was seen.
    pub fn see_run(&self, took: &Took, follows: bool, period: u32) {
        self.delay.see(took.delay, took);
        self.duration.see(took.ended.wrapping_sub(took.began), took);
        if follows {
            self.spacing.see(took.began.wrapping_sub(self.began.get()).abs_diff(period), took);
        }
        self.began.set(took.began);
    }
}
