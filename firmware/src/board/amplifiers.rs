//! What stands in for the current loop where there is none: amplifiers make the current of a duty, and the chip measures nothing.
//!
//! The image for three motors has no loop: three bridges leave no legs to drive each of them unipolar ([`super::bridges`]), and the
//! settings that ask for one are refused.

use core::convert::Infallible;

use cohold_core::device::{encoder::Counts, stage::Measured};
use cohold_core::settings::{Allowed, Refused, Settings};
use firmware_parts::exchange::{Reader, Writer};
use firmware_parts::image::{Actuators, JOINTS};
use firmware_parts::rate::Rate;

pub(crate) use super::no_loop::{PERIODS, RING, TOLD, forget_runs, init, period, reported, run, runs, supply_mv};

/// What the tick would tell the loop.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Order {}

/// What the loop would tell the tick.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {}

/// The loop of one set of settings: there is none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Power(Infallible);

pub(crate) fn prepare(_: Reader<'static, Order>, _: Writer<'static, Sums>) {}

impl Power {
    /// Refuses any drive but amplifiers: there is no current loop.
    pub(crate) fn build(settings: &Settings, _: Rate) -> Result<Self, Refused<'static>> {
        let only = Allowed::Only("amplifier, because the image for three axes has no current loop");
        Err(settings.refuses("motor.drive", only))
    }
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
    pub(crate) fn act(&mut self, power: &Power, _: &Actuators, _: [Counts; JOINTS]) {
        match power.0 {}
    }

    #[inline(always)]
    pub(crate) fn rest(&mut self, _: [Counts; JOINTS]) {}
}
