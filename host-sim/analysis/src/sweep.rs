//! One number of a scene, swept: which key, between which values, at which points first.
//!
//! Values are set on the scene as it is and the result is judged, so that a sweep of a key that the linear scene has no use for
//! (a gap, a push) is flat rather than wrong.

use cohold_core::settings::{Allowed, Value};
use cohold_sim::scene::Scene;

use super::modes::Hands;
use super::verdict::Analyser;
use crate::error::Error;

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

impl Range {
    /// From 0 to `to`.
    pub(crate) fn up_to(key: &str, to: f64) -> Self {
        Self { key: key.to_owned(), from: 0.0, to }
    }
}

/// Keys that enter forces as a factor.
const GAINS: [&str; 4] = [
    "contact.stiffness_n_per_m",
    "contact.damping_n_s_per_m",
    "coordination.stiffness_n_per_m",
    "coordination.damping_n_s_per_m",
];

/// A scene in which one key changes.
#[derive(Clone, Debug)]
pub(crate) struct Sweep {
    /// As the user wrote it, but for recordings.
    scene: Scene,
    /// The key that is swept, and its range.
    pub(crate) range: Range,
    /// The key takes whole numbers only.
    pub(crate) whole: bool,
    /// With every wall met ([`Scene::at_walls`]).
    at_walls: bool,
}

impl Sweep {
    /// Checks that the key is a number and that the scene accepts both ends of the range.
    pub(crate) fn new(scene: &Scene, range: Range) -> Result<Self, Error> {
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
            (Some(_), Some(allowed)) => return Err(Error::NoNumber { key: range.key, allowed }),
        };
        if !(range.from < range.to && range.from.is_finite() && range.to.is_finite()) {
            return Err(Error::Range { key: range.key, from: range.from, to: range.to });
        }
        let sweep = Self { scene, range, whole, at_walls: false };
        sweep.at(sweep.range.from)?;
        sweep.at(sweep.range.to)?;
        Ok(sweep)
    }

    /// The key enters forces as a factor, and nothing else: delays and times stay as they are.
    pub(crate) fn is_gain(&self) -> bool {
        GAINS.contains(&self.range.key.as_str())
    }

    /// The scene with this value of the key (the nearest whole one, for a key that takes no others).
    pub(crate) fn at(&self, value: f64) -> Result<Scene, Error> {
        let mut scene = self.scene.clone();
        scene.set_number(&self.range.key, if self.whole { value.round() } else { value })?;
        Ok(scene.at_walls().filter(|_| self.at_walls).unwrap_or(scene))
    }

    /// The same with every wall met, if there are walls.
    pub(crate) fn met(&self) -> Option<Self> {
        let met = Self { at_walls: true, ..self.clone() };
        [self.range.from, self.range.to]
            .into_iter()
            .any(|value| self.at(value).is_ok_and(|scene| scene.at_walls().is_some()))
            .then_some(met)
    }

    /// The largest spectral radius at this value, of one mode or of all that the scene can enter.
    pub(crate) fn radius(&self, analyser: &mut Analyser, value: f64, hands: Option<Hands>) -> Result<f64, Error> {
        analyser.radius(&self.at(value)?, hands)
    }

    /// Values of a scan, ascending, both ends included: half of them equally spaced and half by equal ratios, but that the one goes
    /// over into the other (down to a millionth of the far end, where the near end is 0); or every whole number where there are few
    /// enough.
    pub(crate) fn points(&self, count: usize) -> Vec<f64> {
        let Range { from, to, .. } = self.range;
        let share = |at: usize, of: usize| at as f64 / of as f64;
        let count = count.max(2);
        if self.whole {
            let (first, last) = (from.round(), to.round());
            let steps = ((last - first) as usize).clamp(1, count);
            let mut points: Vec<f64> =
                (0..=steps).map(|at| (first + (last - first) * share(at, steps)).round()).collect();
            points.dedup();
            return points;
        }
        if from < 0.0 || to <= 0.0 {
            return (0..=count).map(|at| from + (to - from) * share(at, count)).collect();
        }
        let near = if from > 0.0 { from } else { 1e-6 * to };
        let ratio = (to / near).ln();
        // How far along a value e^log is, from 0 to 1, and how fast that grows with log.
        let along = |log: f64| 0.5 * (log / ratio + (log.exp() - 1.0) * near / (to - near));
        let speed = |log: f64| 0.5 * (1.0 / ratio + log.exp() * near / (to - near));
        let mut log = ratio;
        let mut points: Vec<f64> = (1..count)
            .rev()
            .map(|at| {
                // Newton's method from above on a function that curves upwards does not overshoot.
                for _ in 0..50 {
                    let step = (along(log) - share(at, count)) / speed(log);
                    log -= step;
                    if step < 1e-9 {
                        break;
                    }
                }
                near * log.exp()
            })
            .collect();
        points.insert(0, to);
        points.push(near);
        points.extend((from < near).then_some(from));
        points.reverse();
        points
    }
}

#[cfg(test)]
#[path = "../tests/inside/sweep.rs"]
mod tests;
