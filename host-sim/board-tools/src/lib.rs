//! A PC's end of a board: its operator, what it records, its calibration, and the first hour with it.
#![forbid(unsafe_code)]

pub mod bringup;
pub mod calibrate;
pub mod consent;
mod error;
pub mod operator;
pub mod recording;
pub mod status;

pub use error::Error;
