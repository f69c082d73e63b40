//! Every value at which the largest of some spectral radii crosses 1, with as few radii as that takes.
//!
//! **Scan.** The points of a scan are looked at from coarse to fine. Between two of them the middle one is computed and compared with what
//! a cubic through its neighbours says. Where it lies there, to within a part of its distance from the circle, the points between need
//! not be looked at: nothing but an excursion that no neighbour feels could cross in between, and come back. Where it does not,
//! both halves are looked at in the same way, down to the points that were given. Each part of a pair (sum and difference, each
//! delay) is followed by itself, and in each every eigenvalue inside the circle: the largest of all has kinks, and what lies deep
//! here may be the largest a little farther.
//!
//! **Bulges.** Up a hump that stays below 1 and down a dip that stays above it, the extreme is looked for, unless the slopes
//! beside it cannot reach the circle before they meet.
//!
//! **Crossings** are closed in between a stable and an unstable point by Chandrupatla's method (1997: inverse quadratic where that is
//! safe, else halving), until both are within the tolerance of each other: a crossing is never an extrapolation.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::spectrum::{Polar, radius};
use super::verdict::{ROUNDING, is_stable};
use crate::error::Error;

/// Steps of the first look at a scan, at least.
const COARSE: usize = 8;

/// How many times as far from the circle as from its prediction a point must be.
const CLEAR: f64 = 4.0;

/// How far, as a natural logarithm, the distance from the circle may be from its prediction instead.
const ALIKE: f64 = 0.3;

/// How far the angle of the largest eigenvalue may be from its prediction, rad, where it is taken for the same.
const TURN: f64 = 0.02;

/// Steps up a hump or down a dip.
const CLIMB_STEPS: usize = 24;

/// Most radii for one crossing: halving alone takes any range below the spacing of f64 with sixty.
const CLOSE_STEPS: usize = 64;

/// The crossings that a search found.
#[derive(Debug)]
pub(crate) struct Found {
    /// Whether the first point is stable.
    pub stable_at_start: bool,
    /// Values at which stability changes, ascending.
    pub crossings: Vec<f64>,
    /// Values that were looked at.
    pub evaluations: usize,
}

/// A value, and for every part the eigenvalues there, the largest first: ln|λ|, less that of the circle, and the angle.
#[derive(Clone, Debug)]
struct Point {
    value: f64,
    parts: Vec<Polar>,
    stable: bool,
}

impl Point {
    fn new(value: f64, parts: Vec<Polar>) -> Self {
        let stable = parts.iter().all(|part| is_stable(radius(part)));
        let height = |[size, angle]: [f64; 2]| [(size.max(1e-300).ln() - ROUNDING).min(700.0), angle];
        let parts = parts.into_iter().map(|part| part.into_iter().map(height).collect()).collect();
        Self { value, parts, stable }
    }

    /// The largest of all parts: not above 0 where stable.
    fn height(&self) -> f64 {
        let highest = self.parts.iter().map(top).fold(f64::NEG_INFINITY, f64::max);
        if self.stable { highest.min(-f64::MIN_POSITIVE) } else { highest.max(f64::MIN_POSITIVE) }
    }
}

/// The largest of a part.
fn top(part: &Polar) -> f64 {
    part.first().map_or(-700.0, |first| first[0])
}

/// What answers for a value, from any thread.
#[derive(Clone, Copy)]
struct Probe<'a>(&'a (dyn Fn(f64) -> Result<Point, Error> + Sync));

impl Probe<'_> {
    fn at(self, value: f64) -> Result<Point, Error> {
        self.0(value)
    }

    fn each(self, values: Vec<f64>) -> Result<Vec<Point>, Error> {
        values.into_par_iter().with_min_len(4).map(|value| self.at(value)).collect()
    }
}

/// Finds all crossings of what `eigenvalues` writes for a value: those of each part, in memory that it keeps from one call to the next.
/// Scanned at `points` (ascending, evenly spaced in a sense in which eigenvalues are smooth), found to `tolerance` (relative);
/// `whole` where only whole numbers may be asked for, and nothing lies between two.
pub(crate) fn crossings<A: Default + Send>(
    points: &[f64],
    whole: bool,
    tolerance: f64,
    eigenvalues: impl Fn(&mut A, f64, &mut Vec<Polar>) -> Result<(), Error> + Sync,
) -> Result<Found, Error> {
    let unused = Mutex::new(Vec::new());
    let memories = || unused.lock().unwrap_or_else(PoisonError::into_inner);
    let at = |value: f64| {
        let mut own = memories().pop().unwrap_or_default();
        let mut parts = Vec::new();
        let asked = eigenvalues(&mut own, value, &mut parts);
        memories().push(own);
        asked.map(|()| Point::new(value, parts))
    };
    let probe = Probe(&at);
    let mut seen = if whole { probe.each(points.to_vec())? } else { scan(probe, points)? };
    let mut evaluations = seen.len();
    if !whole {
        let smooth = &seen[usize::from(points[0] == 0.0)..];
        let bulges: Vec<&[Point]> = smooth.windows(3).filter(|three| may_cross(three)).collect();
        let climbed = bulges.into_par_iter().map(|three| climb(probe, three));
        let climbed = climbed.collect::<Result<Vec<_>, Error>>()?.concat();
        evaluations += climbed.len();
        seen.extend(climbed);
        seen.sort_by(|a, b| a.value.total_cmp(&b.value));
    }
    let turns: Vec<&[Point]> = seen.windows(2).filter(|pair| pair[0].stable != pair[1].stable).collect();
    let closed = turns.into_par_iter().map(|pair| close_in(probe, pair, whole, tolerance));
    let closed = closed.collect::<Result<Vec<_>, Error>>()?;
    Ok(Found {
        stable_at_start: seen.first().is_some_and(|point| point.stable),
        crossings: closed.iter().map(|(crossing, _)| *crossing).collect(),
        evaluations: evaluations + closed.iter().map(|(_, spent)| spent).sum::<usize>(),
    })
}

/// The points that must be looked at, ascending.
fn scan(probe: Probe<'_>, points: &[f64]) -> Result<Vec<Point>, Error> {
    let mut known: Vec<Option<Point>> = vec![None; points.len()];
    let look = |known: &mut [Option<Point>], asked: Vec<usize>| {
        let found = probe.each(asked.iter().map(|at| points[*at]).collect())?;
        asked.into_iter().zip(found).for_each(|(at, point)| known[at] = Some(point));
        Ok::<(), Error>(())
    };
    let last = points.len() - 1;
    // A key of 0 may leave out what any other value has: a step by itself.
    let first = usize::from(points[0] == 0.0 && last > 1);
    let stride = 1 << (last / COARSE).max(1).ilog2();
    let coarse: Vec<usize> = (first..last).step_by(stride).chain([last]).collect();
    let mut open: Vec<[usize; 2]> = coarse.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    look(&mut known, if first > 0 { [vec![0], coarse].concat() } else { coarse })?;
    loop {
        open.retain(|[left, right]| right - left > 1);
        if open.is_empty() {
            return Ok(known.into_iter().flatten().collect());
        }
        look(&mut known, open.iter().map(|[left, right]| left.midpoint(*right)).collect())?;
        let halves = open.into_iter().filter(|interval| !is_foreseen(&known, first, *interval));
        open = halves.flat_map(|[left, right]| [[left, left.midpoint(right)], [left.midpoint(right), right]]).collect();
    }
}

/// Whether the middle of an interval lies where its neighbours say, so that nothing between can be on another side than they are.
fn is_foreseen(known: &[Option<Point>], first: usize, [left, right]: [usize; 2]) -> bool {
    let before = (first..left).rev().find(|at| known[*at].is_some());
    let after = (right + 1..known.len()).find(|at| known[*at].is_some());
    let near: Vec<usize> = before.into_iter().chain([left, right]).chain(after).collect();
    let near: Vec<(f64, &Point)> = near.into_iter().filter_map(|at| Some((at as f64, known[at].as_ref()?))).collect();
    let at = left.midpoint(right);
    let (Some(left), Some(middle), Some(right)) = (&known[left], &known[at], &known[right]) else { return false };
    let three = [left, middle, right];
    // Where a part or a state comes or goes, nothing can be said.
    let sizes = |point: &Point| point.parts.iter().map(Vec::len).collect::<Vec<_>>();
    if near.iter().any(|(_, point)| sizes(point) != sizes(middle)) {
        return false;
    }
    // What is outside at two neighbours, but no part of it at both, may be inside between them.
    let common = |a: &Point, b: &Point| {
        a.stable || b.stable || a.parts.iter().zip(&b.parts).any(|(a, b)| top(a) > 0.0 && top(b) > 0.0)
    };
    if !common(left, middle) || !common(middle, right) {
        return false;
    }
    let says = |of: &dyn Fn(&Point) -> f64| cubic(at as f64, near.iter().map(|(at, point)| (*at, of(point))));
    let off = |of: &dyn Fn(&Point) -> f64| (of(middle) - says(of)).abs();
    let follows = |part: usize, place: usize| {
        let height = move |point: &Point| point.parts[part][place][0];
        let [low, here, high] = three.map(height);
        let clearance = CLEAR * off(&height);
        if (low > 0.0) != (high > 0.0) {
            return clearance <= here.abs() && clearance <= (high - low).abs();
        }
        let alike = || {
            near.iter().all(|(_, point)| (height(point) > 0.0) == (here > 0.0))
                && off(&|point: &Point| height(point).abs().ln()) <= ALIKE
        };
        (here > 0.0) == (low > 0.0) && (clearance <= low.abs().min(here.abs()).min(high.abs()) || alike())
    };
    // The same eigenvalue all the way.
    let goes_on = |part: usize, place: usize| off(&|point: &Point| point.parts[part][place][1]) <= TURN;
    let inside = |part: usize| three.iter().all(|point| top(&point.parts[part]) <= 0.0);
    let outside = |part: usize| three.iter().all(|point| top(&point.parts[part]) > 0.0);
    let parts = || (0..middle.parts.len()).filter(|part| !middle.parts[*part].is_empty());
    // What is outside hides all but the next: the largest is mostly one of a pair.
    let count = |part: usize| if outside(part) { 3.min(middle.parts[part].len()) } else { middle.parts[part].len() };
    let smooth = |part: usize| {
        (0..count(part)).all(|place| follows(part, place) && (place > 2 || inside(part) || goes_on(part, place)))
    };
    // One part that stays outside decides alone.
    parts().any(|part| outside(part) && smooth(part)) || parts().all(smooth)
}

/// What the polynomial through these points is at a place (Lagrange).
fn cubic(at: f64, points: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let others = points.clone();
    let weight = |own: f64| {
        others
            .clone()
            .filter(|(other, _)| *other != own)
            .map(|(other, _)| (at - other) / (own - other))
            .product::<f64>()
    };
    points.map(|(own, height)| height * weight(own)).sum()
}

/// How far an extreme between three points can be beyond the middle one: to where the slopes beside it meet, at the most.
fn reach([before, middle, after]: [(f64, f64); 3]) -> f64 {
    let slope = |a: (f64, f64), b: (f64, f64)| ((b.1 - a.1) / (b.0 - a.0)).abs();
    let (left, right) = (middle.0 - before.0, after.0 - middle.0);
    (slope(before, middle) * right).max(slope(middle, after) * left)
}

/// Whether a hump or a dip stands between three points that could cross the circle there.
fn may_cross(three: &[Point]) -> bool {
    let [before, middle, after] = [&three[0], &three[1], &three[2]];
    if before.stable != middle.stable || middle.stable != after.stable {
        return false;
    }
    let heights = [before, middle, after].map(|point| (point.value, point.height()));
    let [low, here, high] = heights.map(|(_, height)| height.abs());
    // Not where nothing changes at all.
    here <= low.min(high) && (low, high) != (here, here) && here <= reach(heights)
}

/// Looks for the extreme between three points, by parabolas where they fit and by the golden section elsewhere; stops where the other
/// side is reached, or out of reach.
fn climb(probe: Probe<'_>, three: &[Point]) -> Result<Vec<Point>, Error> {
    const GOLDEN: f64 = 0.381_966_011_250_105_1;
    let side = three[1].stable;
    let distance = |point: &Point| (point.value, point.height().abs());
    let [mut low, mut best, mut high] = [0, 1, 2].map(|at| distance(&three[at]));
    let mut seen = Vec::new();
    for step in 0..CLIMB_STEPS {
        let (left, right) = (best.0 - low.0, high.0 - best.0);
        // Where the parabola through the three is lowest: every other time at the most, and not where one has been already.
        let (to_low, to_high) = (right * (low.1 - best.1), left * (high.1 - best.1));
        let parabola = best.0 + 0.5 * (to_low * right - to_high * left) / (to_low + to_high);
        let golden = if right > left { best.0 + GOLDEN * right } else { best.0 - GOLDEN * left };
        let clearance = 1e-3 * (high.0 - low.0);
        let good = step % 2 == 0
            && parabola - low.0 > clearance
            && high.0 - parabola > clearance
            && (parabola - best.0).abs() > clearance;
        let point = probe.at(if good { parabola } else { golden })?;
        let new = distance(&point);
        let crossed = point.stable != side;
        seen.push(point);
        if crossed {
            break;
        }
        let (edge, inner) = if new.1 < best.1 { (best, new) } else { (new, best) };
        if edge.0 < inner.0 {
            low = edge
        } else {
            high = edge
        }
        best = inner;
        if best.1 > reach([low, best, high]) {
            break;
        }
    }
    Ok(seen)
}

/// Closes in between a point on either side; the crossing and how many radii it took.
fn close_in(probe: Probe<'_>, pair: &[Point], whole: bool, tolerance: f64) -> Result<(f64, usize), Error> {
    // The newest point, and the newest on the other side of the circle.
    let [mut other, mut new] = [0, 1].map(|at| (pair[at].value, pair[at].height()));
    // Where to look next, from the newest on as a share of what is between: at first where a line through both is 0.
    let mut share = new.1 / (new.1 - other.1);
    for spent in 0..CLOSE_STEPS {
        let wide = (other.0 - new.0).abs();
        let enough = if whole { 1.0 } else { tolerance * new.0.abs().max(other.0.abs()) };
        if wide <= enough {
            return Ok((0.5 * (new.0 + other.0), spent));
        }
        // Not nearer to an end than half of what is enough, so that this step can be the last.
        let nearest = (0.45 * enough / wide).min(0.5);
        let value = new.0 + share.clamp(nearest, 1.0 - nearest) * (other.0 - new.0);
        let point = probe.at(if whole { (0.5 * (new.0 + other.0)).floor() } else { value })?;
        let next = (point.value, point.height());
        let before = if (next.1 > 0.0) == (new.1 > 0.0) {
            std::mem::replace(&mut new, next)
        } else {
            let before = other;
            other = std::mem::replace(&mut new, next);
            before
        };
        share = inverse_quadratic(new, other, before);
    }
    Ok((0.5 * (new.0 + other.0), CLOSE_STEPS))
}

/// Where the inverse parabola through three points is 0, as a share of the way from the first to the second, which lies on the other side;
/// half way where the parabola is no function of the height.
fn inverse_quadratic(new: (f64, f64), other: (f64, f64), before: (f64, f64)) -> f64 {
    let along = (new.0 - other.0) / (before.0 - other.0);
    let up = (new.1 - other.1) / (before.1 - other.1);
    if up * up < along && (1.0 - up) * (1.0 - up) < 1.0 - along {
        new.1 / (other.1 - new.1) * before.1 / (other.1 - before.1)
            + (before.0 - new.0) / (other.0 - new.0) * new.1 / (before.1 - new.1) * other.1 / (before.1 - other.1)
    } else {
        0.5
    }
}

#[cfg(test)]
#[path = "../tests/inside/search.rs"]
mod tests;
