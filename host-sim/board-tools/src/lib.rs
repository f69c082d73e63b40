//! A PC's end of a board: its operator, what it records, its calibration, the first hour with it, and its image.
#![forbid(unsafe_code)]

pub mod bringup;
pub mod calibrate;
mod error;
pub mod image;
pub mod operator;
pub mod recording;
pub mod status;

pub use error::Error;
