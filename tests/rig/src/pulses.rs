//! PE9's pulses, from the edges that the rig captures: what the board commands, when that changes, and whether changes come in step.
//!
//! The board's timer counts up and down, and takes new commands where it turns below, in the middle of a high pulse. So a low pulse belongs to
//! one command alone, and its middle is the middle of a period, whatever the command is.
//!
//! Times are counts of 240 MHz, modulo 2³².

/// Counts of a period of 50 µs.
pub const PERIOD: u32 = 12_000;
/// What was seen of the pulses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pulses {
    /// Length of the last low pulse; `None` before the first.
    low: Option<u32>,
    /// Its middle, and its end.
    middle: u32,
    end: u32,
    /// Middle of the last period whose command was another than the one before's; `None` before the first.
    changed: Option<u32>,
    /// Periods of a tick.
    tick: u32,
    /// What is counted.
    pub seen: Seen,
}

/// Sums since [`Pulses::count`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seen {
    /// Periods.
    pub periods: u32,
    /// Commands that differ from the one before.
    pub changes: u32,
    /// Of these, how many came a tick after the last one.
    pub in_step: u32,
    /// Of these, how many came after another time than a whole number of ticks.
    pub off: u32,
    /// How far a change was from a whole number of periods after the last one, at the most.
    pub residue: u32,
    /// Periods that did not come, between two that did.
    pub missing: u32,
}

impl Pulses {
    /// A low pulse has ended.
    pub fn see(&mut self, fell: u32, rose: u32) {
        let low = rose.wrapping_sub(fell);
        if low > PERIOD {
            // It was off before.
            return;
        }
        let middle = fell.wrapping_add(low / 2);
        if let Some(before) = self.low {
            let (periods, _) = whole(middle.wrapping_sub(self.middle));
            self.seen.periods = self.seen.periods.wrapping_add(1);
            self.seen.missing = self.seen.missing.saturating_add(periods.saturating_sub(1));
            // A capture is good to a count.
            if before.abs_diff(low) > 2 {
                self.change(middle);
            }
        }
        (self.low, self.middle, self.end) = (Some(low), middle, rose);
    }

    fn change(&mut self, middle: u32) {
        self.seen.changes = self.seen.changes.wrapping_add(1);
        if let Some(last) = self.changed {
            let (periods, residue) = whole(middle.wrapping_sub(last));
            self.seen.in_step += u32::from(periods == self.tick);
            self.seen.off += u32::from(!periods.is_multiple_of(self.tick));
            self.seen.residue = self.seen.residue.max(residue);
        }
        self.changed = Some(middle);
    }

    /// Sums begin anew, with ticks of so many periods.
    pub fn count(&mut self, tick: u32) {
        (self.tick, self.seen) = (tick, Seen::default());
    }

    /// What the board commands, as a share of full current; none while there are no pulses, as seen from `now`.
    pub fn share(&self, now: u32) -> f32 {
        match self.low {
            Some(low) if now.wrapping_sub(self.end) < 2 * PERIOD => 1.0 - low as f32 * (2.0 / PERIOD as f32),
            _ => 0.0,
        }
    }

    /// How far the command is from no current, of 6000; 0 while there are no pulses, as seen from `now`.
    pub fn asked(&self, now: u32) -> u32 {
        self.low.filter(|_| now.wrapping_sub(self.end) < 2 * PERIOD).map_or(0, |low| low.abs_diff(PERIOD / 2))
    }

    /// From the last pulse's end, and from the beginning of the last period whose command was new, to `then`.
    pub fn until(&self, then: u32) -> [u32; 2] {
        let begun = self.changed.unwrap_or(self.middle).wrapping_sub(PERIOD / 2);
        [then.wrapping_sub(self.end), then.wrapping_sub(begun)]
    }
}

/// How many periods this is, to the nearest, and how far it is from that.
fn whole(counts: u32) -> (u32, u32) {
    let periods = counts.wrapping_add(PERIOD / 2) / PERIOD;
    (periods, counts.abs_diff(periods.wrapping_mul(PERIOD)))
}

#[cfg(test)]
#[path = "../tests/inside/pulses.rs"]
mod tests;
