//! Runs against an independent oracle, and calibration of a simulated board.

mod calibrate;
mod oracle;
