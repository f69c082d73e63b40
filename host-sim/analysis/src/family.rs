//! The matrices of a sweep without driving a peer for each: a gain enters every entry as a polynomial, or nearly so.
//!
//! What the matrices of a mode are (rest modes divided out) is measured at Chebyshev's points of the range, 9 or 17 of them, as the
//! scene that a value makes is driven anywhere else. The next finer points tell whether the polynomial through them is the
//! function: each entry there must be as measured to [`EXACT`] of the largest, in balanced units. Where it is not (a law that switches, a gain
//! in a denominator), or states come and go, there is no family and every value is driven. Values outside the points (0, where
//! a spring is not there at all) are driven too.
//!
//! Evaluated by the barycentric formula (Berrut & Trefethen 2004). What is found in a family is asked of the peers again before it is
//! said: see [`super::limit`].

use super::error::Error;
use super::matrix::{Matrix, column_mut, reset};
use super::modes::Hands;
use super::spectrum::{Polar, balance};
use super::sweep::Sweep;
use super::verdict::{Analyser, Reduced};

/// How exactly a value between must be foreseen, relative to the largest entry.
const EXACT: f64 = 1e-12;

/// Beyond this, finer points would be of no use.
const HOPELESS: f64 = 1e-3;

/// Intervals between the points at first, and at most.
const INTERVALS: [usize; 2] = [4, 8];

/// Matrices at the points of one sweep and mode.
pub(crate) struct Family {
    /// Ascending values, each with the matrix of every part.
    points: Vec<(f64, Vec<Reduced>)>,
    /// The units of each part's states.
    units: Vec<Vec<f64>>,
}

impl Family {
    /// The family of a mode from `low` to `high`, if there is one.
    pub(crate) fn of(sweep: &Sweep, mode: Hands, [low, high]: [f64; 2]) -> Result<Option<Self>, Error> {
        let mut analyser = Analyser::default();
        let mut measure = |at: usize, of: usize| {
            let share = 0.5 - 0.5 * (std::f64::consts::PI * at as f64 / of as f64).cos();
            // The ends exactly.
            let value = low * (1.0 - share) + high * share;
            Ok::<_, Error>((value, analyser.matrices(&sweep.at(value)?, mode)?))
        };
        let mut intervals = INTERVALS[0];
        let mut family = Self { points: Vec::new(), units: Vec::new() };
        for at in 0..=intervals {
            let point = measure(at, intervals)?;
            if !family.takes(at, point) {
                return Ok(None);
            }
        }
        while intervals <= INTERVALS[1] {
            let between = (1..2 * intervals).step_by(2).map(|at| Ok((at, measure(at, 2 * intervals)?)));
            let between = between.collect::<Result<Vec<_>, Error>>()?;
            let off = between.iter().map(|(_, point)| family.off(point)).fold(0.0, f64::max);
            if !between.into_iter().all(|(at, point)| family.takes(at, point)) || off > HOPELESS {
                return Ok(None);
            }
            if off <= EXACT {
                return Ok(Some(family));
            }
            intervals *= 2;
        }
        Ok(None)
    }

    /// Takes a point in at its place, in the units of the first; false where it has other states.
    fn takes(&mut self, at: usize, mut point: (f64, Vec<Reduced>)) -> bool {
        if let Some((_, known)) = self.points.first() {
            let alike = |(a, b): (&Reduced, &Reduced)| a.states == b.states && a.matrix.nrows() == b.matrix.nrows();
            if known.len() != point.1.len() || !known.iter().zip(&point.1).all(alike) {
                return false;
            }
        } else {
            self.units = point.1.iter().map(|part| units(&part.matrix)).collect();
        }
        for (part, units) in point.1.iter_mut().zip(&self.units) {
            rescale(&mut part.matrix, units);
        }
        self.points.insert(at, point);
        true
    }

    /// How far a measured point is from what the others say, relative to its largest entry.
    fn off(&self, (value, parts): &(f64, Vec<Reduced>)) -> f64 {
        let mut said = Matrix::zeros(0, 0);
        let difference = parts.iter().zip(&self.units).enumerate().map(|(part, (measured, units))| {
            let known = self.points.first().and_then(|(_, known)| known.get(part));
            if known.is_none_or(|known| known.matrix.shape() != measured.matrix.shape()) {
                return f64::INFINITY;
            }
            let mut measured = measured.matrix.clone();
            rescale(&mut measured, units);
            self.write(part, *value, &mut said);
            let difference = (&measured - &said).amax();
            // Also where an entry is not finite.
            if difference.is_finite() { difference / measured.amax().max(f64::MIN_POSITIVE) } else { f64::INFINITY }
        });
        difference.fold(0.0, f64::max)
    }

    /// Whether a value lies within the points.
    pub(crate) fn holds(&self, value: f64) -> bool {
        let [first, last] = [self.points.first(), self.points.last()].map(|point| point.map(|(value, _)| *value));
        first.is_some_and(|first| first <= value) && last.is_some_and(|last| value <= last)
    }

    /// The eigenvalues of every part at a value.
    pub(crate) fn eigenvalues(&self, analyser: &mut Analyser, value: f64, parts: &mut Vec<Polar>) -> Result<(), Error> {
        let Some((_, known)) = self.points.first() else { return Ok(()) };
        for (part, reduced) in known.iter().enumerate() {
            parts.push(analyser.polar(|matrix| self.write(part, value, matrix), reduced.held)?);
        }
        Ok(())
    }

    /// Writes the matrix of a part at a value: the polynomial through all points, by its barycentric form.
    fn write(&self, part: usize, value: f64, matrix: &mut Matrix) {
        let Some((_, known)) = self.points.first() else { return };
        if let Some((_, parts)) = self.points.iter().find(|(point, _)| *point == value) {
            return matrix.clone_from(&parts[part].matrix);
        }
        let last = self.points.len() - 1;
        let weight = |at: usize| {
            let ends = if at == 0 || at == last { 0.5 } else { 1.0 };
            (if at.is_multiple_of(2) { ends } else { -ends }) / (value - self.points[at].0)
        };
        let sum: f64 = (0..=last).map(weight).sum();
        let size = known[part].matrix.nrows();
        reset(matrix, size, size);
        for (at, (_, parts)) in self.points.iter().enumerate() {
            let share = weight(at) / sum;
            for (entry, own) in matrix.as_mut_slice().iter_mut().zip(parts[part].matrix.as_slice()) {
                *entry += share * own;
            }
        }
    }
}

/// The units in which a matrix is balanced.
fn units(matrix: &Matrix) -> Vec<f64> {
    let mut units = vec![1.0; matrix.nrows()];
    if matrix.iter().all(|entry| entry.is_finite()) {
        balance(&mut matrix.clone(), |at, factor| units[at] *= factor);
    }
    units
}

/// Brings a matrix to other units.
fn rescale(matrix: &mut Matrix, units: &[f64]) {
    for (j, unit) in units.iter().enumerate() {
        for (entry, own) in column_mut(matrix, j).iter_mut().zip(units) {
            *entry *= unit / own;
        }
    }
}

#[cfg(test)]
#[path = "../tests/inside/family.rs"]
mod tests;
