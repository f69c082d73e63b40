//! A PC's end of a board: its operator, what it records, and its calibration.

pub mod calibrate;
pub mod operator;
pub mod recording;
