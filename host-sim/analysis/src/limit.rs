//! Every value of one key at which a scene changes between stable and unstable.
//!
//! A scan of the range finds changes from point to point, passing over points that their neighbours foresee; between them, the largest
//! |eigenvalue| is followed up every hump that stays below 1 and down every dip that stays above it, so that a pocket narrower than a
//! step is still found if it makes its neighbours bulge. Each change is then closed in ([`super::search`]).
//! Along a gain the matrices need not be driven one by one ([`super::family`]); what is found so is then asked of the peers themselves, a
//! tolerance before and after each crossing, and if they say otherwise all of it is driven. A pocket that no
//! eigenvalue at a scan point tells of can be missed: `step` in the result says how wide the widest step of the scan was. Tried
//! on seventy sweeps beside a plain scan of sixteen times as many points (`tests/suite/sweeps.rs`): none was.
//!
//! Each mode is looked at alone, away from walls and at them, and has a limit of its own; the limit of all is where the first of them is
//! unstable. [`Effort::hands`] keeps it to one.

use cohold_sim::scene::Scene;
use serde::Serialize;

use super::family::Family;
use super::modes::{Hands, entered, worst};
use super::search::{Found, crossings};
use super::spectrum::Polar;
use super::sweep::{Range, Sweep};
use super::verdict::{Analyser, is_stable};
use crate::error::Error;

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
    /// Why values that do not count as stable are not judged, if so.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_judged_because: Option<&'static str>,
    /// The same in each mode that was looked at.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub modes: Vec<InMode>,
}

/// The limit in one mode.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct InMode {
    /// Whose hands are on, and whether the walls are met.
    pub mode: String,
    /// The limit there.
    #[serde(flatten)]
    pub limit: Limit,
}

impl Limit {
    /// What was found among these points.
    pub(crate) fn new(found: Found, points: &[f64]) -> Self {
        let Found { stable_at_start, crossings, evaluations } = found;
        let step = points.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        Self { stable_at_start, crossings, evaluations, step, not_judged_because: None, modes: Vec::new() }
    }

    /// The modes that are unstable at `value`.
    pub fn unstable_modes(&self, value: f64) -> impl Iterator<Item = &str> {
        self.modes.iter().filter(move |one| !one.limit.is_stable(value)).map(|one| one.mode.as_str())
    }

    /// The limit of what is stable where all of these are.
    fn of_all(modes: Vec<InMode>) -> Self {
        let limits: Vec<&Self> = modes.iter().map(|one| &one.limit).collect();
        let mut turns: Vec<(f64, usize)> = (0..)
            .zip(&limits)
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
        let crossings = turns.into_iter().filter_map(crosses).collect();
        let evaluations = limits.iter().map(|limit| limit.evaluations).sum();
        let step = limits.iter().map(|limit| limit.step).fold(0.0, f64::max);
        Self { stable_at_start, crossings, evaluations, step, not_judged_because: None, modes }
    }

    /// Whether the scene is stable at `value`.
    pub fn is_stable(&self, value: f64) -> bool {
        self.stable_at_start == (self.crossings.iter().filter(|crossing| **crossing < value).count() % 2 == 0)
    }
}

/// Finds all crossings of the scene along a range.
///
/// # Errors
/// A key that takes no numbers, a scene that cannot be judged, or eigenvalues that do not converge.
pub fn limit(scene: &Scene, range: Range, effort: Effort) -> Result<Limit, Error> {
    along(&Sweep::new(scene, range)?, effort)
}

/// Finds all crossings along a sweep.
pub(crate) fn along(sweep: &Sweep, effort: Effort) -> Result<Limit, Error> {
    // Each mode by itself: the worst of all has flat stretches of one that hide the humps of another.
    let points = sweep.points(effort.steps);
    let met = sweep.met();
    let away = entered(effort.hands).into_iter().map(|mode| (sweep, mode, false));
    let at_walls = met.iter().flat_map(|met| entered(effort.hands).into_iter().map(move |mode| (met, mode, true)));
    let in_mode = |(sweep, mode, at_walls): (&Sweep, Hands, bool)| {
        let limit = Limit::new(of_mode(sweep, &points, effort.tolerance, mode)?, &points);
        Ok(InMode { mode: mode.named(at_walls), limit })
    };
    let limit = Limit::of_all(away.chain(at_walls).map(in_mode).collect::<Result<_, Error>>()?);
    let edges = [&points[..1], &limit.crossings, &points[points.len() - 1..]].concat();
    let mut analyser = Analyser::default();
    let mut because = |middle: f64| Ok(worst(&analyser.modes(&sweep.at(middle)?, effort.hands)?).not_judged_because);
    let middles = edges.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).filter(|middle| !limit.is_stable(*middle));
    let because = middles.map(&mut because).collect::<Result<Vec<_>, Error>>()?;
    Ok(Limit { not_judged_because: because.into_iter().flatten().next(), ..limit })
}

/// All crossings in one mode: in the family of its matrices where there is one and the driven peers confirm what is
/// found in it, else by driving the peers at every value.
fn of_mode(sweep: &Sweep, points: &[f64], tolerance: f64, mode: Hands) -> Result<Found, Error> {
    let driven = |analyser: &mut Analyser, value: f64, parts: &mut Vec<Polar>| {
        sweep.radius(analyser, value, Some(mode))?;
        parts.append(&mut analyser.parts);
        Ok(())
    };
    let inner = [points[usize::from(points[0] == 0.0 && points.len() > 1)], points[points.len() - 1]];
    let family = if sweep.is_gain() && inner[0] < inner[1] { Family::of(sweep, mode, inner)? } else { None };
    if let Some(family) = family {
        let followed = |analyser: &mut Analyser, value: f64, parts: &mut Vec<Polar>| {
            if family.holds(value) {
                family.eigenvalues(analyser, value, parts)
            } else {
                driven(analyser, value, parts)
            }
        };
        let mut found = crossings(points, sweep.whole, tolerance, followed)?;
        found.evaluations += 2 * found.crossings.len();
        if bears_out(sweep, &found, tolerance, mode)? {
            return Ok(found);
        }
    }
    crossings(points, sweep.whole, tolerance, driven)
}

/// Whether the peers, driven a tolerance before and after each crossing, are on the side that was found.
fn bears_out(sweep: &Sweep, found: &Found, tolerance: f64, mode: Hands) -> Result<bool, Error> {
    let mut analyser = Analyser::default();
    for (at, crossing) in found.crossings.iter().enumerate() {
        for (factor, before) in [(1.0 - tolerance, true), (1.0 + tolerance, false)] {
            let stable = is_stable(sweep.radius(&mut analyser, factor * crossing, Some(mode))?);
            if stable != (found.stable_at_start == ((at % 2 == 0) == before)) {
                return Ok(false);
            }
        }
    }
    Ok(true)
}
