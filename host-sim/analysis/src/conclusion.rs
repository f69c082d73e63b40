//! What is to be said of a run of a scene, composed once: what came of it, what the analyser has against it, what to change, and how
//! heavy the object felt. Command line, Python, sweeps and studies all say this, of one shared axis or of several.

use cohold_core::names::Choice;
use cohold_sim::measure::apparent_mass;
use cohold_sim::run::{Outcome, Reason};
use cohold_sim::scene::Scene;
use cohold_sim::user::User;

use super::advice::advice;
use super::modes::{Hands, Judgement, Mode, judge};
use super::verdict::{Verdict, verdict};
use crate::error::Error;

/// What the analyser says of a scene.
#[derive(Clone, Debug)]
pub struct Analysis {
    /// With both hands on, at the delay of its network: of a run in which nobody lets go.
    pub verdict: Verdict,
    /// Of every mode that it can enter, at every delay that its network can have. A scene that a run shows to be stable may be unstable
    /// where a hand lets go.
    pub judged: Judgement,
}

impl Analysis {
    /// Of this scene.
    ///
    /// # Errors
    /// A scene that cannot be analysed.
    pub fn of(scene: &Scene) -> Result<Self, Error> {
        let judged = judge(scene)?;
        // Where none of its other delays is worse, what was judged of both hands is the verdict, to the bit.
        let own = |mode: &&Mode| {
            mode.mode == Hands::Both && !mode.at_walls && mode.at_delay_ticks.is_none() && mode.at_tautness.is_none()
        };
        let verdict = match judged.modes.iter().find(own) {
            Some(mode) => mode.verdict,
            None => verdict(scene)?,
        };
        Ok(Self { verdict, judged })
    }

    /// That the scene is unstable, with what to change, or that it is where the object is let go of, if so.
    fn unstable(&self, scene: &Scene) -> Result<Option<String>, Error> {
        if !self.verdict.stable {
            return advice(scene).map(Some);
        }
        let Judgement { worst, .. } = &self.judged;
        let (hands, radius) = (self.judged.worst_mode().name(), worst.spectral_radius);
        Ok((!worst.stable).then(|| {
            format!(
                "unstable where the object is let go of (hands on: {hands}, spectral radius {radius:.6}): `stability point` says \
                 what to change"
            )
        }))
    }
}

/// A run of a scene, with what the analyser says of the scene.
#[derive(Clone, Debug)]
pub struct Conclusion {
    /// What the run gave. Where nothing failed in it, its [`Outcome::reason`] is what the analyser has against it: an oscillation may be
    /// too slow, or a push too small, to show.
    pub outcome: Outcome,
    /// What the analyser says of the scene, whatever the run showed.
    pub analysis: Analysis,
}

/// The conclusion of a run of this scene.
///
/// # Errors
/// A scene that cannot be analysed.
pub fn conclude(scene: &Scene, outcome: Outcome) -> Result<Conclusion, Error> {
    Ok(Conclusion::new(scene, outcome, Analysis::of(scene)?))
}

impl Conclusion {
    /// The conclusion where the scene is analysed already.
    pub fn new(scene: &Scene, outcome: Outcome, analysis: Analysis) -> Self {
        let verdict = analysis.verdict;
        let doubted = scene.is_linear() && !verdict.stable;
        let reason = doubted.then_some(match verdict.not_judged_because {
            Some(because) => Reason::NotJudged { because },
            None => Reason::Unstable { spectral_radius: verdict.spectral_radius },
        });
        Self { outcome: outcome.doubted(reason), analysis }
    }

    /// Apparent mass of the shared object, kg, along the first axis. There is none if the scene is not stable in every mode that its line
    /// reaches, if nothing moves, or if the forces do not follow a mass.
    ///
    /// # Errors
    /// A scene whose peers cannot be built.
    pub fn apparent_mass_kg(&self, scene: &Scene) -> Result<Option<f64>, Error> {
        let stable = self.outcome.is_stable() && self.analysis.verdict.stable;
        let mass = stable.then(|| apparent_mass::measure(scene)).transpose()?;
        Ok(mass.filter(|mass| mass.is_finite() && *mass > 0.0))
    }

    /// What whoever runs this scene should know: that it is unstable, with what to change; that it is where the object is let go of; that
    /// nobody pushes.
    ///
    /// # Errors
    /// A scene that cannot be analysed.
    pub fn warnings(&self, scene: &Scene) -> Result<Vec<String>, Error> {
        let mut warnings = Vec::from_iter(self.analysis.unstable(scene)?);
        if !scene.users.iter().any(User::acts) {
            warnings.push("nobody pushes: set user.1.push_n (or load a scene)".to_owned());
        }
        Ok(warnings)
    }
}
