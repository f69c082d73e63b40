//! Numbers that a paper, the documentation or a reviewed table prints.
#![forbid(unsafe_code)]

pub mod accuracy;
pub mod bench;
pub mod campaign;
pub mod entrant;
mod error;
pub mod estimate;
pub mod figures;
pub mod force;
pub mod networks;
pub mod paired;
pub mod precision;
pub mod proof;
pub mod record;
pub mod reproduce;
pub mod study;
pub mod sweep;
pub mod transparency;

pub use error::Error;
