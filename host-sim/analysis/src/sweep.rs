//! One number of a scene, swept: which key, between which values, at which points first.
//!
//! Values are set on the scene as it is and the result is judged, so that a sweep of a key that the linear scene has no use for
//! (a gap, a push) is flat rather than wrong.

use haptic_core::settings::{Allowed, Value};

use super::modes::{Hands, entered};
use super::verdict::{Analyser, Verdict};
use crate::error::AnalysisError;
use haptic_sim::scene::Scene;

/// A key and the values it runs through.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// `table.key`, any number of a scene.
    pub key: String,
    /// First value, in the key's unit.
    pub from: f64,
    /// Last value, larger than the first.
    pub to: f64,
}

/// A scene in which one key changes.
#[derive(Clone, Debug)]
pub(crate) struct Sweep {
    /// As the user wrote it, but for recordings.
    scene: Scene,
    range: Range,
    whole: bool,
}

impl Sweep {
    /// Checks that the key is a number and that the scene accepts both ends of the range.
    pub(crate) fn new(scene: &Scene, range: Range) -> Result<Self, AnalysisError> {
        let mut scene = scene.clone();
        // Recordings are no part of what is judged, and long.
        scene.network_trace = None;
        scene.users.iter_mut().for_each(|user| user.trace = None);
        let keys = scene.keys();
        let allowed = keys.iter().find(|(name, _)| *name == range.key).map(|(_, key)| key.allowed);
        let whole = match (scene.get(&range.key), allowed) {
            (Some(Value::Number(_)), Some(Allowed::Whole { .. })) => true,
            // An unknown key is what setting it will complain about, with a hint.
            (Some(Value::Number(_)) | None, _) | (_, None) => false,
            (Some(_), Some(allowed)) => return Err(AnalysisError::NoNumber { key: range.key, allowed }),
        };
        if !(range.from < range.to && range.from.is_finite() && range.to.is_finite()) {
            return Err(AnalysisError::Range { key: range.key, from: range.from, to: range.to });
        }
        let sweep = Self { scene, range, whole };
        sweep.at(sweep.range.from)?;
        sweep.at(sweep.range.to)?;
        Ok(sweep)
    }

    /// The range.
    pub(crate) fn range(&self) -> &Range {
        &self.range
    }

    /// The key takes whole numbers only.
    pub(crate) fn is_whole(&self) -> bool {
        self.whole
    }

    /// The scene with this value of the key (the nearest whole one, for a key that takes no others).
    pub(crate) fn at(&self, value: f64) -> Result<Scene, AnalysisError> {
        let mut scene = self.scene.clone();
        scene.set_number(&self.range.key, if self.whole { value.round() } else { value })?;
        Ok(scene)
    }

    /// The verdict at this value, both hands on.
    pub(crate) fn verdict(&self, analyser: &mut Analyser, value: f64) -> Result<Verdict, AnalysisError> {
        analyser.verdict(&self.at(value)?.linear())
    }

    /// The largest spectral radius at this value, of one mode or of all that the scene can enter.
    pub(crate) fn radius(
        &self,
        analyser: &mut Analyser,
        value: f64,
        hands: Option<Hands>,
    ) -> Result<f64, AnalysisError> {
        analyser.radius(&self.at(value)?, hands)
    }

    /// The modes that are looked at: the one that is asked for, or all that the scene can enter.
    pub(crate) fn modes(&self, only: Option<Hands>) -> Vec<Hands> {
        entered(only)
    }

    /// Values to look at first, ascending, both ends included: half of them equally spaced, half by equal ratios (down to
    /// a millionth of the far end, where the near end is 0), or every whole number where there are few enough.
    pub(crate) fn points(&self, count: usize) -> Vec<f64> {
        let Range { from, to, .. } = self.range;
        let share = |at: usize, of: usize| at as f64 / of as f64;
        let mut points: Vec<f64> = if self.whole {
            let (first, last) = (from.round(), to.round());
            let steps = ((last - first) as usize).clamp(1, count.max(1));
            (0..=steps).map(|at| (first + (last - first) * share(at, steps)).round()).collect()
        } else {
            let half = (count / 2).max(1);
            let near = if from > 0.0 { from } else { 1e-6 * to };
            let linear = (0..=half).map(|at| from + (to - from) * share(at, half));
            let ratios =
                (0..half).map(|at| near * (to / near).powf(share(at, half))).filter(|_| to > 0.0 && from >= 0.0);
            linear.chain(ratios).filter(|value| *value >= from && *value <= to).collect()
        };
        points.sort_by(f64::total_cmp);
        points.dedup();
        points
    }
}

#[cfg(test)]
#[path = "../tests/inside/sweep.rs"]
mod tests;
