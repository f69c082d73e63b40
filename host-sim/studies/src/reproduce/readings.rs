//! What the cooperation paper leaves open, as scenes: every choice tried.

use rayon::prelude::*;

use cohold_analysis::{Effort, Limit, Range, limit};
use cohold_core::names::Choice;
use cohold_core::object::IntegratorName;
use cohold_sim::scene::Scene;

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
    let integrators = IntegratorName::ALL.iter().filter(|name| !name.solves()).map(|name| name.name());
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

/// How far the paper's gains are looked for, N/m.
pub(super) const TO_N_PER_M: f64 = 12_000.0;

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

/// Masses and dampings of devices that a paper which names neither may have had, from the least to the most.
pub(super) const MASSES_KG: [f64; 4] = [0.05, 0.1, 0.2, 0.3];
pub(super) const DAMPINGS_N_S_PER_M: [f64; 3] = [0.3, 1.0, 2.0];

/// The boundary behind which a scene is unstable that is nearest to a gain, N/m.
pub(super) fn boundary(found: &Limit, gain_n_per_m: f64) -> f64 {
    let ends = found.crossings.iter().enumerate().filter(|(at, _)| found.stable_at_start == (at % 2 == 0));
    let off = |crossing: f64| (crossing - gain_n_per_m).abs();
    ends.map(|(_, crossing)| *crossing).min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap_or(f64::NAN)
}

/// How that boundary moves with the device, of which the paper gives neither mass nor damping: the least and the largest, and the device with which it
/// is nearest to the gain, with it, N/m.
pub(super) fn over_devices(scene: &Scene, gain_n_per_m: f64) -> Result<([f64; 2], [f64; 2], f64), Error> {
    let of = |device: &[f64; 2]| -> Result<f64, Error> {
        let mut scene = scene.clone();
        scene.apply_override(&format!("device.mass_kg={}", device[0]))?;
        scene.apply_override(&format!("device.damping_n_s_per_m={}", device[1]))?;
        Ok(boundary(&crossings(&scene, 2.0 * gain_n_per_m)?, gain_n_per_m))
    };
    let devices = MASSES_KG.map(|mass| DAMPINGS_N_S_PER_M.map(|damping| [mass, damping]));
    let devices = devices.as_flattened();
    let all: Vec<f64> = devices.par_iter().map(of).collect::<Result<_, _>>()?;
    let off = |at: &usize| (all[*at] / gain_n_per_m - 1.0).abs();
    let nearest =
        (0..all.len()).filter(|at| all[*at].is_finite()).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0);
    Ok((super::span(all.iter().copied()), devices[nearest], all[nearest]))
}
