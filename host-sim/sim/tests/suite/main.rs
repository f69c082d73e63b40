//! Runs against an independent oracle, calibration of a simulated board, recordings, and reports.

mod bringup;
mod calibrate;
mod calibrate_winding;
mod double_double;
mod engine;
mod faults;
mod impulsive;
mod lanes;
mod leader_follower;
mod link;
mod measure;
mod midpoint;
mod node;
mod oracle;
mod outcome;
mod precision;
mod recording;
mod report;
mod self_timed;
mod shared;
mod tanks;
mod unlike;
mod winding;
