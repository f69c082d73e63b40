//! What the motors press both hands with: the largest force, and its largest change from one tick of a peer to its next.
//!
//! It is another force than F_T: contact lets through what it can, limits cut off the rest. Along several axes both are lengths of vectors.
//! Who never says what the motors press with has no such figures.

use super::Figure;

/// The forces of both peers' motors along `SHARED` axes.
#[derive(Clone, Copy, Debug)]
pub struct Hands<const SHARED: usize, F = f64> {
    last: [[F; SHARED]; 2],
    /// Of either peer, N.
    peak: F,
    change: F,
    told: bool,
}

impl<const SHARED: usize, F: Figure> Hands<SHARED, F> {
    /// Before the first tick, when no motor presses.
    pub fn new() -> Self {
        Self { last: [[F::ZERO; SHARED]; 2], peak: F::ZERO, change: F::ZERO, told: false }
    }

    /// Takes in what the motors of peer `at` (0 or 1) press with in a tick, N.
    #[inline(always)]
    pub fn see(&mut self, at: usize, forces: [F; SHARED]) {
        let mut changes = forces;
        changes.iter_mut().zip(self.last[at]).for_each(|(change, last)| *change = *change - last);
        self.peak = self.peak.larger(length(forces));
        self.change = self.change.larger(length(changes));
        self.last[at] = forces;
        self.told = true;
    }

    /// With what `of` makes of each number.
    pub(crate) fn map<G: Copy>(&self, of: impl Fn(F) -> G + Copy) -> Hands<SHARED, G> {
        let Self { last, peak, change, told } = *self;
        Hands { last: last.map(|forces| forces.map(of)), peak: of(peak), change: of(change), told }
    }
}

impl<const SHARED: usize, F: Figure> Default for Hands<SHARED, F> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const SHARED: usize> Hands<SHARED> {
    /// The largest force, N; NaN of who was never told.
    pub fn peak_n(&self) -> f64 {
        if self.told { self.peak } else { f64::NAN }
    }

    /// Its largest change in a tick, N; NaN of who was never told.
    pub fn change_n(&self) -> f64 {
        if self.told { self.change } else { f64::NAN }
    }
}

/// Length of a vector; of one axis the absolute value, to the bit.
fn length<const SHARED: usize, F: Figure>(parts: [F; SHARED]) -> F {
    match parts.as_slice() {
        [one] => one.abs(),
        several => several.iter().fold(F::ZERO, |sum, part| sum + *part * *part).root(),
    }
}
