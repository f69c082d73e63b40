//! Numbers that a paper, the documentation or a reviewed table prints.

pub mod accuracy;
pub mod architectures;
pub mod campaign;
pub mod figures;
pub(crate) mod paper;
pub(crate) mod precision;
pub mod record;

type Failure = Box<dyn std::error::Error + Send + Sync>;
