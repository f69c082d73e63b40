//! Numbers that a paper, the documentation or a reviewed table prints.

pub mod accuracy;
pub mod architectures;
pub mod campaign;
pub mod costs;
pub mod figures;
pub mod paper;
pub mod precision;
pub mod record;
