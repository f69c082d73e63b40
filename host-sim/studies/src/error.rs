//! Why a study has no numbers.

/// Why a study has no numbers: one line.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A setting has a value that it does not accept.
    #[error(transparent)]
    Setting(#[from] haptic_core::settings::Refused<'static>),
    /// A scene, a file or a value that is not allowed.
    #[error(transparent)]
    Sim(#[from] haptic_sim::Error),
    /// An analysis that could not be made.
    #[error(transparent)]
    Analysis(#[from] haptic_analysis::Error),
    /// A file of results that cannot be written.
    #[error(transparent)]
    Report(#[from] haptic_report::Error),
    /// Anything else, in a sentence.
    #[error("{0}")]
    Refused(String),
}

haptic_sim::sentences_are_refusals!(Error);
