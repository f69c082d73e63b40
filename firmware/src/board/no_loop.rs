//! What others ask of the current loop where there is none: the chip measures nothing.

use cohold_core::device::stage::Measured;
use cohold_core::names::MotorDrive;
use firmware_parts::image::JOINTS;
use firmware_parts::record::Period;

use super::pace::Run;

/// PWM periods in a millisecond, and runs that are remembered: there are none.
pub(crate) const PERIODS: u32 = 0;
pub(crate) const RING: u32 = 1;
pub(crate) const TOLD: u32 = 0;

#[expect(clippy::unnecessary_wraps, reason = "the converter of a current loop may not come")]
pub(crate) fn init() -> Result<(), &'static str> {
    Ok(())
}

pub(crate) fn runs() -> u32 {
    0
}

pub(crate) fn forget_runs() {}

pub(crate) fn run(_: u32) -> Run {
    Run { began: 0, ended: 0, late: 0, first: true }
}

pub(crate) fn period(_: u32) -> Period {
    Period::default()
}

/// The supply of the bridges: nobody measures it.
pub(crate) fn supply_mv(_: MotorDrive) -> Option<u32> {
    None
}

/// What a record tells of what was measured.
pub(crate) fn reported(_: Option<&Measured<JOINTS>>) -> Option<&'static Measured> {
    None
}
