//! What is to be said of a run of a scene, composed once: what came of it, what the analyser has against it, what to change, and how
//! heavy the object felt. Command line, Python, sweeps and studies all say this, of one shared axis or of several.

use haptic_core::names::Choice;
use haptic_sim::measure::apparent_mass;
use haptic_sim::run::{Outcome, Reason};
use haptic_sim::scene::Scene;
use haptic_sim::user::User;

use super::advice::advice;
use super::modes::judge;
use super::verdict::{Verdict, verdict};
use crate::error::Error;

/// A run of a scene, with what the analyser says of the scene.
#[derive(Clone, Debug)]
pub struct Conclusion {
    /// What the run gave. Where nothing failed in it, its [`Outcome::reason`] is what the analyser has against it: an oscillation may be
    /// too slow, or a push too small, to show.
    pub outcome: Outcome,
    /// The verdict with both hands on.
    pub verdict: Verdict,
}

/// The conclusion of a run of this scene.
///
/// # Errors
/// A scene that cannot be analysed.
pub fn conclude(scene: &Scene, outcome: Outcome) -> Result<Conclusion, Error> {
    Ok(Conclusion::new(scene, outcome, verdict(scene)?))
}

impl Conclusion {
    /// The conclusion where the verdict with both hands on is known already.
    pub fn new(scene: &Scene, outcome: Outcome, verdict: Verdict) -> Self {
        let doubted = scene.is_linear() && !verdict.stable;
        let reason = doubted.then_some(Reason::Unstable { spectral_radius: verdict.spectral_radius });
        Self { outcome: outcome.doubted(reason), verdict }
    }

    /// Apparent mass of the shared object, kg, along the first axis; none of a scene that is not stable, or where nothing moves.
    ///
    /// # Errors
    /// A scene whose peers cannot be built.
    pub fn apparent_mass_kg(&self, scene: &Scene) -> Result<Option<f64>, Error> {
        if !(self.outcome.is_stable() && self.verdict.stable) {
            return Ok(None);
        }
        Ok(Some(apparent_mass::measure(scene)?).filter(|mass| mass.is_finite()))
    }

    /// What whoever runs this scene should know: that it is unstable, with what to change; that it is where the object is let go of; that
    /// nobody pushes.
    ///
    /// # Errors
    /// A scene that cannot be analysed.
    pub fn warnings(&self, scene: &Scene) -> Result<Vec<String>, Error> {
        let mut warnings = Vec::from_iter(unstable(scene, &self.verdict)?);
        if !scene.users.iter().any(User::acts) {
            warnings.push("nobody pushes: set user.1.push_n (or load a scene)".to_owned());
        }
        Ok(warnings)
    }
}

/// That the scene is unstable, with what to change, or that it is where the object is let go of, if so. `verdict` is the scene's, with
/// both hands on.
fn unstable(scene: &Scene, verdict: &Verdict) -> Result<Option<String>, Error> {
    if !verdict.stable {
        return advice(scene).map(Some);
    }
    let judged = judge(scene)?;
    let (hands, radius) = (judged.worst_mode().name(), judged.worst.spectral_radius);
    Ok((!judged.worst.stable).then(|| {
        format!(
            "unstable where the object is let go of (hands on: {hands}, spectral radius {radius:.6}): `stability point` says \
             what to change"
        )
    }))
}
