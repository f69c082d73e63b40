//! A PC's end of a board: calibration and bring-up of a simulated one, and what it records.

mod bringup;
mod calibrate;
mod calibrate_winding;
mod lease;
mod on_path;
mod recording;
