//! The legs of bridges, or the inputs of amplifiers: which pins they are at, and what is written to their channels ([`super::bridges`]).

#[cfg(not(feature = "three-axes"))]
use core::sync::atomic::Ordering;

use cohold_core::device::motor::Duty;
use embassy_stm32::gpio::OutputType;
use embassy_stm32::peripherals::{PE9, PE11, PE13, PE14};
use embassy_stm32::{Peri, pac, timer::simple_pwm::PwmPin};
#[cfg(feature = "three-axes")]
use embassy_stm32::{
    peripherals::{PE8, PE10, PE12},
    timer::complementary_pwm::ComplementaryPwmPin,
};
use firmware_parts::image::JOINTS;

#[cfg(not(feature = "three-axes"))]
use super::bridges::DRIVEN;
use super::bridges::{GATE, MIDDLE, TOP};

/// A voltage that is all of the supply.
#[cfg(not(feature = "three-axes"))]
pub(crate) const COUNTS: u16 = TOP;
/// How many legs a bridge has.
const LEGS: usize = if cfg!(feature = "three-axes") { 1 } else { 2 };
/// The channels of the timer that are legs.
pub(super) const CHANNELS: core::ops::Range<usize> = 0..LEGS * JOINTS;
/// What the gate's channel is compared with while it is open: more than the counter ever is.
const GATE_OPEN: u16 = TOP + 1;

/// Leads pins to their channels, for as long as there is power.
macro_rules! lead {
    ($kind:ident: $($pin:expr),*) => {
        $(core::mem::forget($kind::new($pin, OutputType::PushPull));)*
    };
}

/// Pins of each bridge's two legs.
#[cfg(not(feature = "three-axes"))]
pub(crate) struct Legs {
    pub(crate) bridge_1: (Peri<'static, PE9>, Peri<'static, PE11>),
    pub(crate) bridge_2: (Peri<'static, PE13>, Peri<'static, PE14>),
}

#[cfg(not(feature = "three-axes"))]
impl Legs {
    pub(super) fn connect(self) {
        let ((one_a, one_b), (two_a, two_b)) = (self.bridge_1, self.bridge_2);
        lead!(PwmPin: one_a, one_b, two_a, two_b);
    }
}

/// Each bridge's two: an output and its complement.
#[cfg(feature = "three-axes")]
pub(crate) struct Legs {
    pub(crate) bridge_1: (Peri<'static, PE9>, Peri<'static, PE8>),
    pub(crate) bridge_2: (Peri<'static, PE11>, Peri<'static, PE10>),
    pub(crate) bridge_3: (Peri<'static, PE13>, Peri<'static, PE12>),
    pub(crate) gate: Peri<'static, PE14>,
}

#[cfg(feature = "three-axes")]
impl Legs {
    pub(super) fn connect(self) {
        let ((one_a, one_b), (two_a, two_b), (three_a, three_b)) = (self.bridge_1, self.bridge_2, self.bridge_3);
        lead!(PwmPin: one_a, two_a, three_a, self.gate);
        lead!(ComplementaryPwmPin: one_b, two_b, three_b);
    }
}

/// Duties as shares of their full current to amplifiers, by the first legs.
#[inline(always)]
pub(crate) fn amplify(duties: [Duty; JOINTS]) {
    for (bridge, duty) in duties.into_iter().enumerate() {
        let leg = bridge * LEGS;
        pac::TIM1.ccr(leg).write(|w| w.0 = share(duty));
    }
}

/// The middle and [`counts`] of a duty's share of it: both in one division, of a number that is never negative.
#[inline(always)]
fn share(duty: Duty) -> u32 {
    const FULL: i32 = Duty::FULL_SCALE as i32;
    const MIDDLE: i32 = self::MIDDLE as i32;
    (2 * MIDDLE * i32::from(duty.0) + (2 * MIDDLE + 1) * FULL).cast_unsigned() / (2 * FULL.cast_unsigned())
}

/// PE14, the amplifiers' gate's own input, from the next period on: high while the outputs are on, or low.
#[inline(always)]
pub(crate) fn gate(open: bool) {
    pac::TIM1.ccr(GATE).write(|w| w.set_ccr(if open { GATE_OPEN } else { 0 }));
}

/// Whether the output of the amplifiers' gate is high.
pub(crate) fn gate_passes() -> bool {
    pac::GPIOD.idr().read().idr(15) == pac::gpio::vals::Idr::HIGH
}

/// The voltage of a bridge, at most [`COUNTS`] either way: the difference of its legs. Of an odd count the first leg has the half more.
#[cfg(not(feature = "three-axes"))]
#[inline(always)]
pub(crate) fn voltage(bridge: usize, counts: i32) {
    let second = counts >> 1;
    let legs = [i32::from(MIDDLE) + counts - second, i32::from(MIDDLE) - second];
    for (leg, compare) in (2 * bridge..).zip(legs) {
        pac::TIM1.ccr(leg).write(|w| w.set_ccr(compare as u16));
    }
}

/// Whether the outputs were turned on, and not off since: what the current loop asks.
#[cfg(not(feature = "three-axes"))]
#[inline(always)]
pub(crate) fn driven() -> bool {
    DRIVEN.load(Ordering::Relaxed)
}

/// A duty in counts of which these are full scale, at most [`TOP`], rounded to the nearest (a tie cannot be). Only the current loop asks for it.
#[cfg(not(feature = "three-axes"))]
#[inline(always)]
pub(crate) fn counts(duty: Duty, full_scale: u16) -> i32 {
    const FULL: i32 = Duty::FULL_SCALE as i32;
    let twice = 2 * i32::from(duty.0) * i32::from(full_scale);
    // |twice| ≤ 2·32768·6000 < 2³¹, and the quotient lies within ±6000: no overflow, and no leg beyond its ends.
    (twice + if twice < 0 { -FULL } else { FULL }) / (2 * FULL)
}
