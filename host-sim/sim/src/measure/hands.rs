//! What the motors press both hands with: the largest force, and its largest change from one tick of a peer to its next.
//!
//! It is another force than F_T: contact lets through what it can, limits cut off the rest. Along several axes both are lengths of vectors.
//! Who never says what the motors press with has no such figures.

use super::Figure;

/// The forces of both peers' motors along `SHARED` axes.
#[derive(Clone, Copy, Debug)]
pub struct Hands<const SHARED: usize, F = f64> {
    last: [[F; SHARED]; 2],
    /// The largest force of either peer, N; NaN of who was never told.
    pub peak: F,
    /// Its largest change in a tick, N; NaN of who was never told.
    pub change: F,
}

impl<const SHARED: usize, F: Figure> Hands<SHARED, F> {
    /// Takes in what the motors of peer `at` (0 or 1) press with in a tick, N.
    #[inline(always)]
    pub fn see(&mut self, at: usize, forces: [F; SHARED]) {
        let mut changes = forces;
        changes.iter_mut().zip(self.last[at]).for_each(|(change, last)| *change = *change - last);
        self.peak = self.peak.larger(length(forces));
        self.change = self.change.larger(length(changes));
        self.last[at] = forces;
    }

    /// With what `of` makes of each number.
    pub(crate) fn map<G: Copy>(&self, of: impl Fn(F) -> G + Copy) -> Hands<SHARED, G> {
        let Self { last, peak, change } = *self;
        Hands { last: last.map(|forces| forces.map(of)), peak: of(peak), change: of(change) }
    }
}

/// Before the first tick, when no motor presses.
impl<const SHARED: usize, F: Figure> Default for Hands<SHARED, F> {
    fn default() -> Self {
        let never = F::from_f64(f64::NAN);
        Self { last: [[F::ZERO; SHARED]; 2], peak: never, change: never }
    }
}

/// Length of a vector; of one axis the absolute value, to the bit.
fn length<const SHARED: usize, F: Figure>(parts: [F; SHARED]) -> F {
    match parts.as_slice() {
        [one] => one.abs(),
        several => several.iter().fold(F::ZERO, |sum, part| sum + *part * *part).root(),
    }
}
