//! Numbers that a paper, the documentation or a reviewed table prints.

pub mod accuracy;
pub mod architectures;
pub mod campaign;
pub mod compare;
pub mod estimate;
pub mod figures;
pub mod force;
pub(crate) mod paper;
pub(crate) mod precision;
pub mod proof;
pub mod published;
pub mod record;
pub(crate) mod reproduce;
pub mod sweep;
pub mod transparency;

use haptic_analysis::Verdict;
use haptic_sim::{run::Reason, scene::Scene};

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// What the analyser has against a run of a scene that is linear: an oscillation may be too slow to grow in it.
pub fn doubt(scene: &Scene, verdict: &Verdict) -> Option<Reason> {
    let unstable = scene.is_linear() && !verdict.stable;
    unstable.then_some(Reason::Unstable { spectral_radius: verdict.spectral_radius })
}
