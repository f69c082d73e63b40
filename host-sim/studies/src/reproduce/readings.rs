//! What the cooperation paper leaves open, as scenes: every choice tried.

use haptic_analysis::{Effort, Limit, Range, limit};
use haptic_core::names::Choice;
use haptic_core::object::IntegratorName;
use haptic_sim::scene::Scene;

use crate::Error;

/// A way to read what the paper leaves open.
#[derive(Clone, Debug)]
pub(super) struct Reading {
    /// The reading in words.
    pub(super) name: String,
    settings: [String; 3],
}

impl Reading {
    /// This scene, read so.
    fn of(&self, scene: &Scene) -> Result<Scene, Error> {
        let mut scene = scene.clone();
        self.settings.iter().try_for_each(|setting| scene.apply_override(setting))?;
        scene.check("reading")?;
        Ok(scene)
    }
}

/// How the copy is integrated, how late its forces are and how late the device's, in ticks.
pub(super) fn readings() -> Vec<Reading> {
    let integrators = IntegratorName::NAMES.iter().filter(|name| **name != IntegratorName::Midpoint.name());
    let late = ["0", "1"];
    let reading = |integrator: &str, object: &str, device: &str| Reading {
        name: format!("copy integrated {integrator}, its forces {object} ticks late, the device's {device}"),
        settings: [
            format!("object.integrator={integrator}"),
            format!("object.force_delay_ticks={object}"),
            format!("device.force_delay_ticks={device}"),
        ],
    };
    let all =
        integrators.flat_map(|integrator| late.map(|object| late.map(|device| reading(integrator, object, device))));
    all.flatten().collect()
}

/// Every K_T up to here at which this scene changes between stable and unstable, N/m.
pub(super) fn crossings(scene: &Scene, to_n_per_m: f64) -> Result<Limit, Error> {
    let range = Range { key: "coordination.stiffness_n_per_m".to_owned(), from: 1.0, to: to_n_per_m };
    Ok(limit(scene, range, Effort::default())?)
}

/// Of all readings the one under which the first crossing is nearest to a gain, and that crossing, N/m.
pub(super) fn nearest(scene: &Scene, gain_n_per_m: f64) -> Result<Option<(String, f64)>, Error> {
    let mut best: Option<(String, f64)> = None;
    for reading in readings() {
        let Some(first) = crossings(&reading.of(scene)?, 2.0 * gain_n_per_m)?.crossings.first().copied() else {
            continue;
        };
        let off = |crossing: f64| (crossing / gain_n_per_m - 1.0).abs();
        if best.as_ref().is_none_or(|(_, known)| off(first) < off(*known)) {
            best = Some((reading.name, first));
        }
    }
    Ok(best)
}

/// The readings under which every gain up to this one is stable, N/m.
pub(super) fn stable_up_to(scene: &Scene, gain_n_per_m: f64) -> Result<Vec<String>, Error> {
    let mut names = Vec::new();
    for reading in readings() {
        let found = crossings(&reading.of(scene)?, gain_n_per_m)?;
        if found.stable_at_start && found.crossings.is_empty() {
            names.push(reading.name);
        }
    }
    Ok(names)
}
