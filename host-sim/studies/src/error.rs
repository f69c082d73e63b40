//! Why a study has no numbers.

/// Why a study has no numbers: one line.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A setting has a value that it does not accept.
    #[error(transparent)]
    Setting(#[from] cohold_core::settings::Refused<'static>),
    /// A scene, a file or a value that is not allowed.
    #[error(transparent)]
    Sim(#[from] cohold_sim::Error),
    /// An analysis that could not be made.
    #[error(transparent)]
    Analysis(#[from] cohold_analysis::Error),
    /// A file of results that cannot be written.
    #[error(transparent)]
    Report(#[from] cohold_report::Error),
    /// Anything else, in a sentence.
    #[error("{0}")]
    Refused(String),
}

cohold_sim::sentences_are_refusals!(Error);
