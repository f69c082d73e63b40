//! Stability, computed from the code that flies.
//!
//! | module | answers |
//! |---|---|
//! | [`mod@verdict`] | is this scene stable, and by how much? |
//! | [`lifted`] | the lifted, or monodromy, matrix of one packet period, built two independent ways |
//! | [`mod@limit`] | at which values of one key does that change? |
//! | [`mod@map`] | and of two keys? |
//! | [`figure4`] | the cooperation paper's Figure 4 |
//! | [`outline`], [`picture`] | regions as pictures |
//! | [`mod@advice`] | what to change in a scene that is unstable |
//! | [`mod@tune`] | the stiffest contact and coordination that leave a margin |
//! | [`rendering`] | one device and one object, delay at any of four places: the architectures paper's Figure 4 |
//! | [`sweep`] | one key, its range and the scenes along it |
//! | [`speed`] | how fast? |
//! | [`spectrum`] | the largest eigenvalue of a matrix |
//!
//! What is analysed is the linear scene behind a scene ([`haptic_sim::scene::Scene::linear`]): permanent two-sided contact,
//! exact sensors and motors, nobody pushing. Gaps, friction, encoder steps and force limits are not part of it.

use haptic_core::settings::{Allowed, Refused};

pub mod advice;
pub mod figure4;
pub mod lifted;
pub mod limit;
pub mod map;
pub mod matrix;
pub mod outline;
pub mod picture;
pub mod rendering;
pub mod spectrum;
pub mod speed;
pub mod sweep;
pub mod tune;
pub mod verdict;

pub use advice::advice;
pub use limit::{Effort, Limit, limit};
pub use sweep::Range;
pub use verdict::{Analyser, Verdict, verdict};

use haptic_sim::scene::SceneError;

/// Why an analysis could not be made, in one line.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisError {
    /// The peer does not accept the settings.
    #[error(transparent)]
    Refused(#[from] Refused<'static>),
    /// The scene does not accept a value of a sweep.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The key of a sweep is a name or a flag.
    #[error("{key} is no number that could be swept: it is {allowed}")]
    NoNumber {
        /// The key.
        key: String,
        /// What it takes.
        allowed: Allowed,
    },
    /// A range that does not ascend.
    #[error("{key}: a range must be two finite numbers that ascend, not from {from} to {to}")]
    Range {
        /// The key.
        key: String,
        /// First value.
        from: f64,
        /// Last value.
        to: f64,
    },
    /// A number outside what an analysis can take.
    #[error("{key} = {value} is not allowed: it must be a number from {min} to {max} {unit}")]
    OutOfRange {
        /// What it is called.
        key: String,
        /// What was offered.
        value: f64,
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
        /// Unit of all three.
        unit: &'static str,
    },
    /// The eigenvalue iteration gave up.
    #[error("the eigenvalues of this scene's lifted matrix did not converge")]
    NoConvergence,
}

impl AnalysisError {
    /// Refuses a number that does not lie within `[min, max]`.
    fn within(key: &str, value: f64, [min, max]: [f64; 2], unit: &'static str) -> Result<(), Self> {
        let inside = value >= min && value <= max;
        if inside { Ok(()) } else { Err(Self::OutOfRange { key: key.to_owned(), value, min, max, unit }) }
    }
}
