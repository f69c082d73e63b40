//! What the analyser says of a law: the largest K_T in every mode, the largest K_LC, and the verdict on the gains as declared.

use cohold_analysis::tune::{CONTACT, COORDINATION};
use cohold_analysis::{Effort, Hands, Judgement, Limit, Range, is_linear, judge, limit};
use cohold_core::names::Choice;
use cohold_sim::measure::impedance::{RemoteEnd, SPEED_M_PER_S, felt};
use cohold_sim::scene::Scene;

use crate::Error;

/// Stiffnesses are looked at from 0 up to this, N/m.
pub const TO_N_PER_M: f64 = 20_000.0;

/// How far what is felt at twice the speed may be off where a law is linear, relative.
const SAME: f64 = 1e-3;

/// A spectral radius above this grows by 10¹⁰ in a run of the campaign, packet by packet of 8 ms: such a run cannot be stable.
pub(crate) const GROWS: f64 = 1.01;

/// Frequencies at which that is looked at, Hz.
const LOOKED_AT_HZ: [f64; 2] = [1.0, 10.0];

/// Stability of a linear law.
#[derive(Clone, Debug)]
pub struct Stability {
    /// Along K_T, with both hands on, one, none ([`Hands::ALL`]).
    pub coordination: Vec<Limit>,
    /// Along K_LC in the worst of the modes, at the K_T that the law declares.
    pub contact: Limit,
    /// At the gains that the law declares.
    pub judgement: Judgement,
}

/// From 0 up to where the scene is unstable for the first time, N/m; [`TO_N_PER_M`] where it never is.
pub fn stable_to(limit: &Limit) -> f64 {
    if limit.stable_at_start { limit.crossings.first().copied().unwrap_or(TO_N_PER_M) } else { 0.0 }
}

/// Limits and verdict, or why there are none; `runs` says that the run on the scene's own network was stable.
///
/// # Errors
/// Why the analyser gives no limits.
pub fn judged(scene: &Scene, runs: bool) -> Result<Stability, Error> {
    if let Some(why) = not_linear(scene)? {
        return Err(why.into());
    }
    let along = |key: &str, hands| {
        let range = Range { key: key.to_owned(), from: 0.0, to: TO_N_PER_M };
        limit(scene, range, Effort { hands, ..Effort::default() })
    };
    let coordination = Hands::ALL.iter().map(|mode| along(COORDINATION, Some(*mode)));
    let stability = Stability {
        coordination: coordination.collect::<Result<_, _>>()?,
        contact: along(CONTACT, None)?,
        judgement: judge(scene)?,
    };
    let both = stability.judgement.modes.iter().find(|mode| mode.mode == Hands::Both);
    if runs && both.is_some_and(|both| both.verdict.spectral_radius > GROWS) {
        // What it does at some size, the matrix of small states does not show.
        return Err("the law is not linear: its run is stable where its matrix is not".into());
    }
    Ok(stability)
}

/// Why no matrix says all of this law, if so.
pub(crate) fn not_linear(scene: &Scene) -> Result<Option<&'static str>, Error> {
    if !is_linear(scene)? {
        return Ok(Some("the law is not linear: its answer to a sum is not the sum of its answers"));
    }
    for frequency_hz in LOOKED_AT_HZ {
        let at = |speed| felt(scene, RemoteEnd::Held, frequency_hz, speed);
        if let (Some(slow), Some(fast)) = (at(SPEED_M_PER_S)?, at(2.0 * SPEED_M_PER_S)?)
            && (fast - slow).norm() > SAME * slow.norm()
        {
            return Ok(Some("the law is not linear: what is felt at twice the speed is another impedance"));
        }
    }
    Ok(None)
}
