//! A PC's end of a board: calibration and bring-up of a simulated one, and what it records.

mod bringup;
mod calibrate;
mod calibrate_winding;
#[path = "../../../../protocol/tests/suite/protocol/format.rs"]
#[allow(dead_code, unreachable_pub)] // What the board of another test says.
mod format;
mod hostile;
mod image;
mod lease;
mod on_path;
mod recording;
