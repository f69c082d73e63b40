//! Runs against an independent oracle, calibration of a simulated board, and recordings.

mod calibrate;
mod oracle;
mod recording;
