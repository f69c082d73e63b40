//! Two motor bridges on one advanced timer, and the three things that keep them off.
//!
//! Locked antiphase: channel and complement of a bridge are its two legs; half duty is no current, so one pair of pins and
//! one dead time drive a bridge both ways. 20 kHz, centre-aligned: 240 MHz / (2 · 6000); 3000 steps from zero to full
//! duty. Dead time 0.5 µs on top of what the driver adds itself.
//!
//! Off is the default three times over: the enable line is low (and pulled down on the wiring while the chip is in reset),
//! the timer's outputs are off (MOE) and then held at their inactive level (OSSI), and a break clears MOE in hardware with no
//! software in between. Three things break, and [`cut`] tells them apart: the emergency stop's contact on the first input, which is
//! pulled down, so that a cut wire is a pressed button; the bridges' own fault output on the second, pulled up because it is an open
//! drain; and the failures of the chip that [`super::breaks`] wires to it. MOE comes back only when the tick begins to drive again
//! ([`wake`], [`on`]). What the break depends on is locked until the next reset (LOCK).
//!
//! Both inputs take a level that 8 samples agree on, 0.27 µs: the bridges' edges are shorter than that, and a press is not. The filter
//! needs the timer's clock; when that stops, the clock security system breaks by itself (RM0433 §38.3.16).
//!
//! [`OFF`] is the same in two stores, for handlers that cannot trust their stack.

use core::sync::atomic::{Ordering, compiler_fence};

use embassy_stm32::gpio::{AfType, Flex, Level, Output, OutputType, Pull, Speed};
use embassy_stm32::pac::timer::vals::{Cms, OcmGp};
use embassy_stm32::peripherals::{PE6, PE8, PE9, PE10, PE11, PE15, PF3, TIM1};
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

/// 8 samples at an eighth of the timer's clock: BKF and BK2F.
const FILTER: u32 = 0b1001;
/// Level 3, all that there is to lock; taken in the first write of the register after a reset, or never.
const LOCK: u32 = 3 << 8;

/// BDTR with the outputs off: dead time, lock, idle level while off, both breaks enabled, active low and filtered.
const BDTR_OFF: u32 = DEAD_CLOCKS | LOCK | 1 << 10 | 1 << 11 | 1 << 12 | FILTER << 16 | FILTER << 20 | 1 << 24;
/// The same with the outputs on.
const BDTR_ON: u32 = BDTR_OFF | 1 << 15;
/// What broke, in SR: first input, second, chip.
const STOP: u32 = 1 << 7;
const BRIDGE: u32 = 1 << 8;
const CHIP: u32 = 1 << 13;
/// PF3 in its port's set/reset register.
const ENABLE_SET: u32 = 1 << 3;
const ENABLE_RESET: u32 = ENABLE_SET << 16;

/// Addresses and values that turn everything off: the enable line, then the timer's outputs.
pub(crate) const OFF: [(u32, u32); 2] = [(0x5802_1418, ENABLE_RESET), (0x4001_0044, BDTR_OFF)];

/// Ticks from enabling the bridges to driving them. They need a millisecond to wake, and may report a fault meanwhile (DRV8874).
pub(crate) const WAKE_TICKS: u32 = 2;

/// What turned the outputs off without being told to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cut {
    /// The emergency stop.
    Stop,
    /// A bridge's fault output.
    Bridge,
    /// Supply, clock or core of the chip; or nothing that left a mark.
    Chip,
}

pub(crate) struct Pins {
    pub(crate) bridge_1: (Peri<'static, PE9>, Peri<'static, PE8>),
    pub(crate) bridge_2: (Peri<'static, PE11>, Peri<'static, PE10>),
    pub(crate) enable: Peri<'static, PF3>,
    pub(crate) stop: Peri<'static, PE15>,
    pub(crate) fault: Peri<'static, PE6>,
}

/// Drives the enable line low: the very first thing, on whatever clock there is.
pub(crate) fn disable() {
    pac::RCC.ahb4enr().modify(|w| w.set_gpiofen(true));
    // The clock is there two cycles after it was enabled (RM0433 §8.5.11); reading back takes longer.
    let _ = pac::RCC.ahb4enr().read();
    pac::GPIOF.bsrr().write(|w| w.0 = ENABLE_RESET);
    pac::GPIOF.moder().modify(|w| w.set_moder(3, pac::gpio::vals::Moder::OUTPUT));
}

/// Starts the timer with its outputs off.
pub(crate) fn init(timer: Peri<'static, TIM1>, pins: Pins) {
    // Low first: whatever follows, the drivers are disabled.
    core::mem::forget(Output::new(pins.enable, Level::Low, Speed::Low));
    // The driver gates its clock; dropping it would stop it.
    core::mem::forget(Timer::new(timer));
    let tim = pac::TIM1;
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
    // Behind the modes and outputs of the channels, which it locks.
    tim.bdtr().write_value(BdtrAdv(BDTR_OFF));
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
    let mut fault = Flex::new(pins.fault);
    // Alternate function 1 of PE6 is its second one.
    fault.set_as_af_unchecked(1, AfType::input(Pull::Up));
    core::mem::forget(fault);
}

/// Duties onto the bridges.
#[inline(always)]
pub(crate) fn drive(duties: [Duty; AXES]) {
    for (channel, duty) in duties.into_iter().enumerate() {
        pac::TIM1.ccr(channel).write(|w| w.set_ccr(compare(duty)));
    }
}

/// Enables the bridges, whose outputs stay off for [`WAKE_TICKS`]. What broke before is forgotten.
#[inline(always)]
pub(crate) fn wake() {
    // Zero clears a flag, one does not touch it.
    pac::TIM1.sr().write(|w| w.0 = !(STOP | BRIDGE | CHIP));
    pac::GPIOF.bsrr().write(|w| w.0 = ENABLE_SET);
}

/// Outputs on, once, when the bridges are awake: nothing else undoes a break, however short it was. They stay off if the emergency stop
/// was pressed since [`wake`] or the chip failed, and the timer does not take it while any of the three still breaks.
#[inline(always)]
pub(crate) fn on() {
    if pac::TIM1.sr().read().0 & (STOP | CHIP) == 0 {
        pac::TIM1.sr().write(|w| w.0 = !BRIDGE);
        pac::TIM1.bdtr().write_value(BdtrAdv(BDTR_ON));
    }
}

/// What turned the outputs off since [`wake`]. A press of the stop takes the bridges' supply, too, and they report it; so does a failing
/// supply: what the others follow from comes first.
pub(crate) fn cut() -> Cut {
    let flags = pac::TIM1.sr().read().0;
    if flags & STOP != 0 {
        Cut::Stop
    } else if flags & CHIP == 0 && flags & BRIDGE != 0 {
        Cut::Bridge
    } else {
        Cut::Chip
    }
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

/// Whether the timer's outputs are on; a break turns them off without asking.
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
