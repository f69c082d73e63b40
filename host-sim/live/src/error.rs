//! Why an end in real time did not start, or ended.

/// Why an end in real time did not start, or ended, or its recording cannot be read: one line.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scene, a file or a value that is not allowed.
    #[error(transparent)]
    Sim(#[from] cohold_sim::Error),
    /// A board, or what was asked of it.
    #[error(transparent)]
    Tools(#[from] cohold_board_tools::Error),
    /// Anything else, in a sentence.
    #[error("{0}")]
    Refused(String),
}

cohold_sim::sentences_are_refusals!(Error);
