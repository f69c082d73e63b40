//! A PC's end of a board: calibration and bring-up of a simulated one, what it records, and a hostile one.

mod bringup;
mod calibrate;
mod calibrate_winding;
#[path = "../../../../protocol/tests/suite/protocol/format.rs"]
mod format;
mod hostile;
mod lease;
mod on_path;
mod recording;
