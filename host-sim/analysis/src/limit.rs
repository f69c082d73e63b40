//! Every value of one key at which a scene changes between stable and unstable.
//!
//! A scan of the range finds changes from point to point; between them, the largest |eigenvalue| is followed up every
//! hump that stays below 1 and down every dip that stays above it, so that a pocket narrower than a step is still found
//! if it makes its neighbours bulge. Each change is then closed in by bisection. A pocket that no scan point feels can be
//! missed: `step` in the result says how wide the widest step was.
//!
//! Which mode is looked at, or that it is the worst of all, is said by [`Effort::hands`].

use rayon::prelude::*;
use serde::Serialize;

use super::modes::Hands;
use super::sweep::{Range, Sweep};
use super::verdict::{Analyser, is_stable};
use crate::error::AnalysisError;
use haptic_sim::scene::Scene;

/// How hard to look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Steps of the first scan.
    pub steps: usize,
    /// How closely a crossing is found, relative to its value.
    pub tolerance: f64,
    /// The mode that is looked at; none, and it is the worst of all that the scene can enter.
    pub hands: Option<Hands>,
}

impl Effort {
    /// The default effort in every mode that the scene can enter.
    pub fn every_mode() -> Self {
        Self { hands: None, ..Self::default() }
    }
}

/// Both hands on, as in the papers' figures.
impl Default for Effort {
    fn default() -> Self {
        Self { steps: 400, tolerance: 1e-4, hands: Some(Hands::Both) }
    }
}

/// Golden-section steps up a hump or down a dip.
const CLIMB_STEPS: usize = 24;

/// All crossings along one key.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Limit {
    /// Whether the scene is stable at the first value.
    pub stable_at_start: bool,
    /// Values at which that changes, ascending; for a key of whole numbers, halfway between two neighbours.
    pub crossings: Vec<f64>,
    /// Spectral radii that were computed.
    pub evaluations: usize,
    /// Widest step of the scan.
    pub step: f64,
}

impl Limit {
    /// The limit of what is stable where all of these are.
    fn of_all(limits: &[Self]) -> Self {
        let mut turns: Vec<(f64, usize)> = (0..)
            .zip(limits)
            .flat_map(|(which, limit)| limit.crossings.iter().map(move |crossing| (*crossing, which)))
            .collect();
        turns.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut stable: Vec<bool> = limits.iter().map(|limit| limit.stable_at_start).collect();
        let all = |stable: &[bool]| stable.iter().all(|stable| *stable);
        let stable_at_start = all(&stable);
        let crosses = |(crossing, which): (f64, usize)| {
            let before = all(&stable);
            stable[which] = !stable[which];
            (all(&stable) != before).then_some(crossing)
        };
        Self {
            stable_at_start,
            crossings: turns.into_iter().filter_map(crosses).collect(),
            evaluations: limits.iter().map(|limit| limit.evaluations).sum(),
            step: limits.iter().map(|limit| limit.step).fold(0.0, f64::max),
        }
    }

    /// Whether the scene is stable at `value`.
    pub fn is_stable(&self, value: f64) -> bool {
        self.stable_at_start == (self.crossings.iter().filter(|crossing| **crossing < value).count() % 2 == 0)
    }
}

/// Finds all crossings of the scene along a range.
pub fn limit(scene: &Scene, range: Range, effort: Effort) -> Result<Limit, AnalysisError> {
    along(&Sweep::new(scene, range)?, effort)
}

/// A value of the key and the spectral radius there.
type Point = (f64, f64);

/// Finds all crossings along a sweep.
pub(crate) fn along(sweep: &Sweep, effort: Effort) -> Result<Limit, AnalysisError> {
    // Each mode by itself: the worst of all has flat stretches of one that hide the humps of another.
    let points = sweep.points(effort.steps);
    let of_mode = |mode: &Hands| {
        let radius = |analyser: &mut Analyser, value: f64| sweep.radius(analyser, value, Some(*mode));
        crossings(&points, sweep.is_whole(), effort.tolerance, Analyser::default, radius)
    };
    let limits = sweep.modes(effort.hands).iter().map(of_mode).collect::<Result<Vec<_>, AnalysisError>>()?;
    Ok(Limit::of_all(&limits))
}

/// Finds all crossings of any spectral radius, given as a function of one number: scanned at `points` (ascending), found to
/// `tolerance` (relative). `memory` makes what the function may keep from one call to the next; `whole` where only whole
/// numbers may be asked for.
pub(crate) fn crossings<A>(
    points: &[f64],
    whole: bool,
    tolerance: f64,
    memory: impl Fn() -> A + Send + Sync,
    radius: impl Fn(&mut A, f64) -> Result<f64, AnalysisError> + Send + Sync,
) -> Result<Limit, AnalysisError> {
    let radius = |memory: &mut A, value: f64| Ok((value, radius(memory, value)?));
    let step = points.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    let scanned: Vec<Point> = points
        .par_iter()
        .map_init(&memory, |memory, value| radius(memory, *value))
        .collect::<Result<_, AnalysisError>>()?;
    let mut evaluations = scanned.len();

    let extremes: Vec<Vec<Point>> = scanned
        .par_windows(3)
        .filter(|three| !whole && is_bulge(three))
        .map_init(&memory, |memory, three| climb(three, |value| radius(memory, value)))
        .collect::<Result<_, AnalysisError>>()?;
    evaluations += extremes.iter().map(Vec::len).sum::<usize>();
    let mut all: Vec<Point> = scanned.into_iter().chain(extremes.into_iter().flatten()).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));

    let found: Vec<(f64, usize)> = all
        .par_windows(2)
        .filter(|pair| stable(pair[0]) != stable(pair[1]))
        .map_init(&memory, |memory, pair| close_in(pair[0], pair[1], whole, tolerance, |value| radius(memory, value)))
        .collect::<Result<_, AnalysisError>>()?;
    evaluations += found.iter().map(|(_, spent)| spent).sum::<usize>();
    Ok(Limit {
        stable_at_start: all.first().is_some_and(|point| stable(*point)),
        crossings: found.into_iter().map(|(value, _)| value).collect(),
        evaluations,
        step,
    })
}

fn stable((_, radius): Point) -> bool {
    is_stable(radius)
}

/// All three on the same side, and the middle one nearest to the other side; not where nothing changes at all.
fn is_bulge(three: &[Point]) -> bool {
    let [before, middle, after] = [three[0], three[1], three[2]];
    let same = stable(before) == stable(middle) && stable(middle) == stable(after);
    let (low, high) = (before.1.min(after.1), before.1.max(after.1));
    same && !(low == high && middle.1 == low) && if stable(middle) { middle.1 >= high } else { middle.1 <= low }
}

/// Golden-section search for the extreme between three points; stops where the other side is reached.
fn climb(
    three: &[Point],
    mut radius: impl FnMut(f64) -> Result<Point, AnalysisError>,
) -> Result<Vec<Point>, AnalysisError> {
    const GOLDEN: f64 = 0.381_966_011_250_105_1;
    let up = stable(three[1]);
    let nearer = |a: Point, b: Point| if up { a.1 > b.1 } else { a.1 < b.1 };
    let (mut low, mut best, mut high) = (three[0].0, three[1], three[2].0);
    let mut seen = Vec::new();
    for _ in 0..CLIMB_STEPS {
        // A new point in the wider half.
        let value = if high - best.0 > best.0 - low {
            best.0 + GOLDEN * (high - best.0)
        } else {
            best.0 - GOLDEN * (best.0 - low)
        };
        let point = radius(value)?;
        seen.push(point);
        if stable(point) != up {
            break;
        }
        let (edge, inner) = if nearer(point, best) { (best.0, point) } else { (value, best) };
        if edge < inner.0 {
            low = edge
        } else {
            high = edge
        }
        best = inner;
    }
    Ok(seen)
}

/// Bisection between a point on either side; the crossing and how many radii it took.
fn close_in(
    mut low: Point,
    mut high: Point,
    whole: bool,
    tolerance: f64,
    mut radius: impl FnMut(f64) -> Result<Point, AnalysisError>,
) -> Result<(f64, usize), AnalysisError> {
    let mut spent = 0;
    // Sixty halvings take any range below the spacing of f64.
    while spent < 60 && if whole { high.0 - low.0 > 1.0 } else { high.0 - low.0 > tolerance * high.0.abs() } {
        let mut value = 0.5 * (low.0 + high.0);
        if whole {
            value = value.floor();
        }
        let middle = radius(value)?;
        spent += 1;
        if stable(middle) == stable(low) { low = middle } else { high = middle }
    }
    Ok((0.5 * (low.0 + high.0), spent))
}
