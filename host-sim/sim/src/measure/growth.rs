//! Whether something grows over a run, judged by the largest value in each eighth of it.

use super::{Figure, Statistics};

/// Share of a swing that is left in the last eighth of a run, of that in the fifth, if it does not die away.
const STAYS: f64 = 0.8;

/// Standard deviation of a force that is no swing, N, whatever users push with.
const LEAST_N: f64 = 0.5;

/// The largest value in each eighth of a run.
#[derive(Clone, Copy, Debug)]
pub struct Growth<F = f64> {
    window: u64,
    /// The eighth that goes on, and the tick at which it is over.
    eighth: usize,
    until: u64,
    largest: [F; 8],
}

impl<F: Figure> Growth<F> {
    /// For a run of `ticks` ticks.
    pub fn new(ticks: u64) -> Self {
        let window = ticks.div_ceil(8).max(1);
        Self { window, eighth: 0, until: window, largest: [F::ZERO; 8] }
    }

    /// Takes in a value of a tick, 0 or more, of none before the last; what is no finite number counts as infinite.
    #[inline(always)]
    pub fn see(&mut self, tick: u64, value: F) {
        // Not a division in every tick: it takes as long as all else here.
        while tick >= self.until {
            (self.eighth, self.until) = ((self.eighth + 1).min(7), self.until + self.window);
        }
        let largest = &mut self.largest[self.eighth];
        *largest = largest.larger(value.or_infinite());
    }

    /// With what `of` makes of each number.
    pub(crate) fn map<G>(&self, of: impl Fn(F) -> G) -> Growth<G> {
        Growth { window: self.window, eighth: self.eighth, until: self.until, largest: self.largest.map(of) }
    }
}

impl Growth {
    /// The largest value so far.
    pub fn largest(&self) -> f64 {
        self.largest.iter().copied().fold(0.0, f64::max)
    }

    /// Whether it grows without bound: at least fourfold over the last four eighths, and in each of them by at least half of
    /// an even logarithmic share, as an exponential does and random packet losses hardly ever do; or whether it was infinite.
    pub fn grew(&self) -> bool {
        let tail = &self.largest[3..];
        let all = tail[4] / tail[0];
        let half_share = all.sqrt().sqrt().sqrt();
        all > 4.0 && tail.windows(2).all(|pair| pair[1] > half_share * pair[0]) || self.largest().is_infinite()
    }
}

/// How a force swings in each eighth of a run.
#[derive(Clone, Debug)]
pub(crate) struct Swing<F = f64> {
    last: F,
    /// In each eighth: the force, its square, and the square of its change from tick to tick.
    sums: [[F; 3]; 8],
}

/// A swing that goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swings {
    /// Its frequency, Hz.
    pub hz: f64,
    /// Standard deviation of the force, N.
    pub rms_n: f64,
}

impl<F: Figure> Swing<F> {
    pub(crate) fn new() -> Self {
        Self { last: F::ZERO, sums: [[F::ZERO; 3]; 8] }
    }

    /// Takes in the force of a tick, N, in the eighth that `growth` is in.
    #[inline(always)]
    pub(crate) fn see(&mut self, &Growth { eighth, .. }: &Growth<F>, force: F) {
        let change = force - self.last;
        self.last = force;
        let values = [force, force * force, change * change];
        self.sums[eighth].iter_mut().zip(values).for_each(|(sum, value)| *sum = *sum + value);
    }

    /// With what `of` makes of each number.
    pub(crate) fn map<G>(&self, of: impl Fn(F) -> G + Copy) -> Swing<G> {
        Swing { last: of(self.last), sums: self.sums.map(|sums| sums.map(of)) }
    }
}

impl Swing {
    /// A swing beyond what users push with, `pushes_n` (N), that does not die away: in each eighth of the last half the force has a larger
    /// standard deviation, and in the last one at least [`STAYS`] of that in the first. Its frequency is that of a sine which changes as much.
    pub(crate) fn goes_on(&self, growth: &Growth, pushes_n: f64, period_s: f64) -> Option<Swings> {
        let ticks = growth.window as f64;
        let of = |sums: &[f64; 3]| Statistics::of_moments(sums[0] / ticks, sums[1] / ticks).sd;
        let [first, .., last] = [4, 5, 6, 7].map(|eighth| of(&self.sums[eighth]));
        let swings = self.sums[4..].iter().all(|sums| of(sums) > pushes_n.max(LEAST_N)) && last >= STAYS * first;
        let change = (self.sums[7][2] / ticks).sqrt();
        let turn = 2.0 * (0.5 * change / last).min(1.0).asin();
        swings.then(|| Swings { hz: turn / (core::f64::consts::TAU * period_s), rms_n: last })
    }
}

/// What forces do over a run: how large they get, by how much they change from tick to tick, and whether that grows.
#[derive(Clone, Debug)]
pub struct Forces<F = f64> {
    last: Vec<F>,
    peak: F,
    changes: Growth<F>,
}

impl<F: Figure> Forces<F> {
    /// For a run of `ticks` ticks that starts from zero force.
    pub fn new(ticks: u64) -> Self {
        Self { last: Vec::new(), peak: F::ZERO, changes: Growth::new(ticks) }
    }

    /// Takes in the forces of a tick, N; as many in every tick.
    #[inline(always)]
    pub fn see(&mut self, tick: u64, forces: impl IntoIterator<Item = F>) {
        for (at, force) in forces.into_iter().enumerate() {
            if at == self.last.len() {
                self.last.push(F::ZERO);
            }
            self.changes.see(tick, (force - self.last[at]).abs());
            self.peak = self.peak.larger(force.abs());
            self.last[at] = force;
        }
    }

    /// With what `of` makes of each number.
    pub(crate) fn map<G>(&self, of: impl Fn(F) -> G + Copy) -> Forces<G> {
        let last = self.last.iter().map(|force| of(*force)).collect();
        Forces { last, peak: of(self.peak), changes: self.changes.map(of) }
    }
}

impl Forces {
    /// Forces of the last tick, N.
    pub fn last(&self) -> &[f64] {
        &self.last
    }

    /// The largest absolute force so far, N.
    pub fn peak(&self) -> f64 {
        self.peak
    }

    /// The largest change of any force from one tick to the next, N.
    pub fn largest_change(&self) -> f64 {
        self.changes.largest()
    }

    /// Whether an oscillation grows: the changes do ([`Growth::grew`]).
    pub fn grew(&self) -> bool {
        self.changes.grew()
    }
}
