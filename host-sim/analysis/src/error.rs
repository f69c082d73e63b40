//! Why an analysis could not be made.

use cohold_core::settings::{Allowed, Refused};

/// Why an analysis could not be made, in one line.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The peer does not accept the settings.
    #[error(transparent)]
    Refused(#[from] Refused<'static>),
    /// A value, or the scene that it would make, is not allowed.
    #[error(transparent)]
    Sim(#[from] cohold_sim::Error),
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
    /// A line that holds still now and then, so that no packet period is like the next.
    #[error("not judged, because the line does not settle at this delay")]
    NotReached,
    /// The eigenvalue iteration gave up.
    #[error("the eigenvalues of this scene's lifted matrix did not converge")]
    NoConvergence,
}

impl Error {
    /// Refuses a number that does not lie within `[min, max]`.
    pub(crate) fn within(key: &str, value: f64, [min, max]: [f64; 2], unit: &str) -> Result<(), Self> {
        if value >= min && value <= max {
            return Ok(());
        }
        let allowed = format!("it must be a number from {min} to {max} {unit}");
        Err(cohold_sim::Error::not_allowed(format!("{key} = {value}"), allowed).into())
    }
}
