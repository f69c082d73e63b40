//! Runs with their figures of merit, and the papers' experiments made of them.

pub mod apparent_mass;
pub mod campaign;
pub mod costs;
pub mod figures;
pub mod paper;
pub mod precision;
pub mod record;
pub mod replay;
pub mod run;
pub mod swing;

pub use run::{Options, Outcome, run};
