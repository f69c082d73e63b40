//! Why a board was not asked, calibrated or brought up.

/// Why a board was not asked, or what was asked of it did not come about: one line.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The board answers a line with something else than `ok`.
    #[error("the board answers {line:?} with {answer:?}")]
    Answer {
        /// What it was asked.
        line: String,
        /// What it said.
        answer: String,
    },
    /// A setting of the board has a value that it does not accept.
    #[error(transparent)]
    Setting(#[from] cohold_core::settings::Refused<'static>),
    /// Settings from which no link can be built.
    #[error(transparent)]
    Link(#[from] cohold_protocol::link::ConfigError),
    /// A scene, a file or a value that is not allowed.
    #[error(transparent)]
    Sim(#[from] cohold_sim::Error),
    /// What reaches the board, or the person at it, failed.
    #[error(transparent)]
    Reach(#[from] Box<dyn std::error::Error + Send + Sync>),
    /// Anything else, in a sentence.
    #[error("{0}")]
    Refused(String),
}

cohold_sim::sentences_are_refusals!(Error);
