//! What stands in for the current loop where there is none: amplifiers make the current of a duty, and the chip measures nothing.
//!
//! The image for three motors has no loop: three bridges leave no legs to drive each of them unipolar ([`super::bridges`]), and the
//! settings that ask for one are refused.

use core::convert::Infallible;

use firmware_parts::exchange::{Reader, Writer};
use firmware_parts::image::JOINTS;
use haptic_core::device::{encoder::Counts, stage::Measured};
use haptic_core::peer::Actuators;
use haptic_core::settings::{Allowed, Refused, Settings};

/// PWM periods in a tick, and runs that are remembered: there are none.
pub(crate) const PERIODS: u32 = 0;
pub(crate) const RING: u32 = 1;

/// What the tick would tell the loop.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Order {}

/// What the loop would tell the tick.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {}

/// The loop of one set of settings: there is none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Power(Infallible);

/// One run of the loop: there is none.
pub(crate) struct Run {
    pub(crate) began: u32,
    pub(crate) ended: u32,
    pub(crate) late: u32,
    pub(crate) first: bool,
}

pub(crate) fn init() {}

pub(crate) fn prepare(_: Reader<'static, Order>, _: Writer<'static, Sums>) {}

pub(crate) fn runs() -> u32 {
    0
}

pub(crate) fn run(_: u32) -> Run {
    Run { began: 0, ended: 0, late: 0, first: true }
}

impl Power {
    /// Refuses any drive but amplifiers: there is no current loop.
    pub(crate) fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        let key = "motor.drive";
        let value = settings.get(key).unwrap_or(haptic_core::settings::Value::Flag(false));
        let allowed = Allowed::Only("amplifier, because the image for three axes has no current loop");
        Err(Refused { key, value, allowed, unit: "" })
    }
}

/// What a record tells of what was measured.
pub(crate) fn reported(_: Option<&Measured<JOINTS>>) -> Option<&'static Measured> {
    None
}

/// The tick's side of the power stage.
pub(crate) struct Stage;

impl Stage {
    pub(crate) fn new(_: Writer<'static, Order>, _: Reader<'static, Sums>) -> Self {
        Self
    }

    #[inline(always)]
    pub(crate) fn measured(&mut self, power: &Power) -> Option<Measured<JOINTS>> {
        match power.0 {}
    }

    #[inline(always)]
    pub(crate) fn act(&mut self, power: &Power, _: &Actuators<f32, JOINTS>, _: [Counts; JOINTS]) {
        match power.0 {}
    }

    #[inline(always)]
    pub(crate) fn rest(&mut self, _: [Counts; JOINTS]) {}
}
