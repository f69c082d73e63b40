//! Numbers that a paper, the documentation or a reviewed table prints.

pub mod accuracy;
pub mod architectures;
pub mod campaign;
pub mod figures;
pub(crate) mod paper;
pub(crate) mod precision;
pub mod record;

/// What a study may fail with.
type Failure = Box<dyn std::error::Error + Send + Sync>;
