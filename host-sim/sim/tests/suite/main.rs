//! Runs against an independent oracle, calibration of a simulated board, recordings, and reports.

mod calibrate;
mod engine;
mod link;
mod oracle;
mod recording;
mod report;
