//! Instructions of every tick, and of every run of the current loop, counted from the entry of the interrupt to its return.
//!
//! The emulator stops at both and says how many instructions it has run: exact, and the same on every run. Nothing preempts the current
//! loop, and nothing else the tick, which ends long before the loop's next run: so what lies between the two is their own. Not cycles:
//! those the emulator does not know.

use crate::image::Firmware;
use crate::node::Hit;

/// Interrupt of the tick.
pub const TICK: &str = "TIM6_DAC";
/// Interrupt of the current loop.
pub const LOOP: &str = "ADC";

/// Counts one board's ticks, or another of its interrupts.
#[derive(Clone, Debug)]
pub struct Meter {
    entry: u64,
    returns: Vec<u64>,
    entered: Option<u64>,
    /// Instructions of every tick since the last [`Meter::clear`].
    pub ticks: Vec<u32>,
    /// When every tick began, ns.
    pub began: Vec<u64>,
    /// How many instructions the board had run when it did: asleep it runs none.
    pub before: Vec<u64>,
}

/// Median and largest of some counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MedianAndMost {
    /// Half of them are at most this.
    pub median: u32,
    /// The largest of them.
    pub max: u32,
}

impl MedianAndMost {
    /// Of these; zero of none.
    pub fn of(counts: impl IntoIterator<Item = u32>) -> Self {
        let mut sorted: Vec<u32> = counts.into_iter().collect();
        sorted.sort_unstable();
        Self { median: sorted.get(sorted.len() / 2).copied().unwrap_or(0), max: sorted.last().copied().unwrap_or(0) }
    }
}

impl Meter {
    /// Of an interrupt of this image.
    pub fn new(firmware: &Firmware, interrupt: &str) -> Self {
        let (entry, returns) = (firmware.address(interrupt), firmware.returns(interrupt));
        Self { entry, returns, entered: None, ticks: Vec::new(), began: Vec::new(), before: Vec::new() }
    }

    /// The instructions to watch.
    pub fn watched(&self) -> impl Iterator<Item = u64> + '_ {
        std::iter::once(self.entry).chain(self.returns.iter().copied())
    }

    /// Takes in what was reached.
    pub fn see(&mut self, hits: &[Hit]) {
        for hit in hits {
            if hit.address == self.entry {
                self.entered = Some(hit.instruction_count);
                self.began.push(hit.at.0);
                self.before.push(hit.instruction_count);
            } else if self.returns.contains(&hit.address) {
                // The return itself has not run yet at its hit, and is the tick's too.
                self.ticks.extend(self.entered.take().map(|entered| (hit.instruction_count - entered + 1) as u32));
            }
        }
    }

    /// Forgets what was counted.
    pub fn clear(&mut self) {
        self.ticks.clear();
        self.began.clear();
        self.before.clear();
    }
}
