//! Two motor bridges on one advanced timer, and the three things that keep them off.
//!
//! Locked antiphase: channel and complement of a bridge are its two legs; half duty is no current, so one pair of pins and
//! one dead time drive a bridge both ways. 20 kHz, centre-aligned: 240 MHz / (2 · 6000); 3000 steps from zero to full
//! duty. Dead time 0.5 µs on top of what the driver adds itself.
//!
//! Off is the default three times over: the enable line is low (and pulled down on the wiring while the chip is in reset),
//! the timer's outputs are off (MOE) and then held at their inactive level (OSSI), and the emergency stop's contact opens
//! the timer's break input, which clears MOE in hardware with no software in between. The break pin is pulled down: a
//! cut wire is a pressed button. MOE comes back only when the tick begins to drive again ([`on`]).
//!
//! [`OFF`] is the same in two stores, for handlers that cannot trust their stack.

use core::sync::atomic::{Ordering, compiler_fence};

use embassy_stm32::gpio::{AfType, Flex, Level, Output, OutputType, Pull, Speed};
use embassy_stm32::pac::timer::vals::{Cms, OcmGp};
use embassy_stm32::peripherals::{PE8, PE9, PE10, PE11, PE15, PF3, TIM1};
use embassy_stm32::{
    Peri, pac, pac::timer::regs::BdtrAdv, timer::complementary_pwm::ComplementaryPwmPin, timer::low_level::Timer,
    timer::simple_pwm::PwmPin,
};
use haptic_core::{device::AXES, device::motor::Duty};

use super::clocks::TIMERS_HZ;

const PWM_HZ: u32 = 20_000;
/// Counts from the middle (no current) to either end (full duty).
pub(crate) const STEPS: u16 = (TIMERS_HZ / PWM_HZ / 4) as u16;
/// Dead time in timer clocks: 0.5 µs.
const DEAD_CLOCKS: u32 = TIMERS_HZ / 2_000_000;
const _: () = assert!(DEAD_CLOCKS < 128, "longer dead times are encoded differently");

/// BDTR with the outputs off: dead time, idle level while off, break enabled and active low.
const BDTR_OFF: u32 = DEAD_CLOCKS | 1 << 10 | 1 << 11 | 1 << 12;
/// The same with the outputs on.
const BDTR_ON: u32 = BDTR_OFF | 1 << 15;
/// PF3 in its port's set/reset register.
const ENABLE_SET: u32 = 1 << 3;
const ENABLE_RESET: u32 = ENABLE_SET << 16;

/// Addresses and values that turn everything off: the enable line, then the timer's outputs.
pub(crate) const OFF: [(u32, u32); 2] = [(0x5802_1418, ENABLE_RESET), (0x4001_0044, BDTR_OFF)];

pub(crate) struct Pins {
    pub(crate) bridge_1: (Peri<'static, PE9>, Peri<'static, PE8>),
    pub(crate) bridge_2: (Peri<'static, PE11>, Peri<'static, PE10>),
    pub(crate) enable: Peri<'static, PF3>,
    pub(crate) stop: Peri<'static, PE15>,
}

/// Starts the timer with its outputs off.
pub(crate) fn init(timer: Peri<'static, TIM1>, pins: Pins) {
    // Low first: whatever follows, the drivers are disabled.
    core::mem::forget(Output::new(pins.enable, Level::Low, Speed::Low));
    // The driver gates its clock; dropping it would stop it.
    core::mem::forget(Timer::new(timer));
    let tim = pac::TIM1;
    tim.bdtr().write_value(BdtrAdv(BDTR_OFF));
    tim.cr1().write(|w| {
        w.set_cms(Cms::CENTER_ALIGNED1);
        w.set_arpe(true);
    });
    tim.arr().write(|w| w.set_arr(2 * STEPS));
    for channel in 0..AXES {
        tim.ccmr_output(0).modify(|w| {
            w.set_ocm(channel, OcmGp::PWM_MODE1);
            w.set_ocpe(channel, true);
        });
        tim.ccr(channel).write(|w| w.set_ccr(STEPS));
        tim.ccer().modify(|w| {
            w.set_cce(channel, true);
            w.set_ccne(channel, true);
        });
    }
    tim.egr().write(|w| w.set_ug(true));
    tim.cr1().modify(|w| w.set_cen(true));
    let (high_1, low_1) = pins.bridge_1;
    let (high_2, low_2) = pins.bridge_2;
    core::mem::forget(PwmPin::new(high_1, OutputType::PushPull));
    core::mem::forget(ComplementaryPwmPin::new(low_1, OutputType::PushPull));
    core::mem::forget(PwmPin::new(high_2, OutputType::PushPull));
    core::mem::forget(ComplementaryPwmPin::new(low_2, OutputType::PushPull));
    let mut stop = Flex::new(pins.stop);
    // Alternate function 1 of PE15 is the timer's break input.
    stop.set_as_af_unchecked(1, AfType::input(Pull::Down));
    core::mem::forget(stop);
}

/// Duties onto the bridges.
#[inline(always)]
pub(crate) fn drive(duties: [Duty; AXES]) {
    for (channel, duty) in duties.into_iter().enumerate() {
        pac::TIM1.ccr(channel).write(|w| w.set_ccr(compare(duty)));
    }
}

/// The bridges on, once, when they begin to be driven: nothing else undoes what the emergency stop did, however briefly it was
/// pressed. While it is pressed the timer does not take it.
#[inline(always)]
pub(crate) fn on() {
    pac::TIM1.bdtr().write_value(BdtrAdv(BDTR_ON));
    pac::GPIOF.bsrr().write(|w| w.0 = ENABLE_SET);
}

/// Everything off: enable line, outputs, and the compare values back to no current.
#[inline(always)]
pub(crate) fn off() {
    pac::GPIOF.bsrr().write(|w| w.0 = ENABLE_RESET);
    pac::TIM1.bdtr().write_value(BdtrAdv(BDTR_OFF));
    for channel in 0..AXES {
        pac::TIM1.ccr(channel).write(|w| w.set_ccr(STEPS));
    }
    compiler_fence(Ordering::SeqCst);
}

/// Whether the timer's outputs are on; the break input turns them off without asking.
#[inline(always)]
pub(crate) fn live() -> bool {
    pac::TIM1.bdtr().read().moe()
}

/// Whether the emergency stop's contact is closed.
pub(crate) fn stop_released() -> bool {
    pac::GPIOE.idr().read().idr(15) == pac::gpio::vals::Idr::HIGH
}

/// The compare value of a duty: the middle plus the duty in [`STEPS`], rounded to the nearest (a tie cannot be).
#[inline(always)]
fn compare(duty: Duty) -> u16 {
    const FULL: i32 = Duty::FULL_SCALE as i32;
    let twice = 2 * i32::from(duty.0) * i32::from(STEPS);
    // |twice| ≤ 2·32768·3000 < 2³¹, and the quotient lies within ±3001: no overflow, no loss.
    let steps = (twice + if twice < 0 { -FULL } else { FULL }) / (2 * FULL);
    (i32::from(STEPS) + steps) as u16
}
