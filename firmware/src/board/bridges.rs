//! Two motor bridges on one advanced timer, or three (feature `three-axes`), and the three things that keep them off.
//!
//! Unipolar: each leg of a bridge is a channel of its own, around half of the period, one as much longer as the other is shorter; no
//! voltage is both legs alike, and no ripple. 20 kHz, centre-aligned: 240 MHz / (2 · 6000); [`TOP`] = 6000 are all of the supply. The dead time is
//! the drivers' own. What is written acts from the next period on, which begins where both legs are high: there the timer updates.
//!
//! Three motors have amplifiers, and a channel each with its complement; the fourth channel is their gate. Timer, breaks and all that keeps
//! them off are the same.
//!
//! Off is the default three times over: the enable line is low (and pulled down on the wiring while the chip is in reset),
//! the timer's outputs are off (MOE) and then held at their inactive level (OSSI), and a break clears MOE in hardware with no
//! software in between. Three things break, and [`cut`] tells them apart: the emergency stop's contact on the first input, which is
//! pulled down, so that a cut wire is a pressed button; the bridges' own fault output on the second, pulled up because it is an open
//! drain; and the failures of the chip that [`super::breaks`] wires to it. MOE comes back only when the tick begins to drive again
//! ([`enable`], [`on`]). What the break depends on is locked until the next reset (LOCK).
//!
//! Both inputs take a level that 8 samples agree on, 0.27 µs: the bridges' edges are shorter than that, and a press is not. The filter
//! needs the timer's clock; when that stops, the clock security system breaks by itself (RM0433 §38.3.16).
//!
//! **Amplifiers** in current mode (`motor.drive = "amplifier"`) take the first leg of each bridge alone: half is no current, and what is low
//! all the time is all of the current backwards. So they must not be enabled while the outputs are off, whatever took these away: a gate on the
//! wiring lets the enable through only while PE14 is high, which is the timer's fourth channel: high all the time while they are to be enabled,
//! and low with the timer's outputs, in hardware. [`super::gate`] has the order, and sees at every start that the gate works.
//!
//! [`OFF`] is the same in two stores, for handlers that cannot trust their stack.

use core::sync::atomic::{AtomicBool, Ordering, compiler_fence};

use cohold_core::{device::current::PWM_HZ, safety::Fault};
use embassy_stm32::gpio::{AfType, Flex, Input, Level, Output, Pull, Speed};
use embassy_stm32::pac::timer::vals::{Cms, OcmGp};
use embassy_stm32::peripherals::{PD15, PE6, PE15, PF3, TIM1};
use embassy_stm32::{Peri, pac, pac::timer::regs::BdtrAdv, timer::low_level::Timer};
#[cfg(not(feature = "moteus"))]
use firmware_parts::rate::Ms;

use super::{clocks::TIMERS_HZ, drive::Cut, legs};

/// Counts from the bottom of the period to its top: a leg that is high all the time, and a voltage that is all of the supply.
pub(super) const TOP: u16 = (TIMERS_HZ / PWM_HZ / 2) as u16;
/// Half of the time: no voltage, and all of an amplifier's current beyond it.
pub(super) const MIDDLE: u16 = TOP / 2;
/// The channel that lets amplifiers be enabled.
pub(super) const GATE: usize = 3;

/// 8 samples at an eighth of the timer's clock: BKF and BK2F.
const FILTER: u32 = 0b1001;
/// Level 3, all that there is to lock; taken in the first write of the register after a reset, or never.
const LOCK: u32 = 3 << 8;

/// BDTR with the outputs off: lock, idle level while off, both breaks enabled, active low and filtered.
const BDTR_OFF: u32 = LOCK | 1 << 10 | 1 << 11 | 1 << 12 | FILTER << 16 | FILTER << 20 | 1 << 24;
/// BDTR with the outputs on, else as [`BDTR_OFF`].
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

/// From enabling the bridges to driving them. They need a millisecond to wake, and may report a fault meanwhile (DRV8874).
#[cfg(not(feature = "moteus"))]
pub(crate) const WAKES: Ms = Ms(2);

/// Outputs were turned on, and not off since: whoever writes voltages without being asked may do so.
pub(super) static DRIVEN: AtomicBool = AtomicBool::new(false);

pub(crate) struct Pins {
    pub(crate) legs: legs::Legs,
    pub(crate) enable: Peri<'static, PF3>,
    pub(crate) stop: Peri<'static, PE15>,
    pub(crate) fault: Peri<'static, PE6>,
    /// Output of the amplifiers' gate.
    pub(crate) gate: Peri<'static, PD15>,
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
    tim.arr().write(|w| w.set_arr(TOP));
    // Every second turn is an update; written before the counter starts, the lower one (RM0433 §38.3.3).
    tim.rcr().write(|w| w.set_rep(1));
    // All four: the one that is no leg is the gate, which is shut until an amplifier is driven.
    for channel in 0..=GATE {
        tim.ccmr_output(channel / 2).modify(|w| {
            w.set_ocm(channel % 2, OcmGp::PWM_MODE1);
            w.set_ocpe(channel % 2, true);
        });
        let leg = legs::CHANNELS.contains(&channel);
        tim.ccr(channel).write(|w| w.set_ccr(if leg { MIDDLE } else { 0 }));
        tim.ccer().modify(|w| {
            w.set_cce(channel, true);
            // The fourth channel has no complement.
            if cfg!(feature = "three-axes") && leg {
                w.set_ccne(channel, true);
            }
        });
    }
    // High from a count before the top to the top: the current loop's second sample (38.3.27).
    tim.ccmr3().modify(|w| w.set_ocm(1, OcmGp::PWM_MODE2));
    tim.ccr6().write(|w| w.set_ccr(TOP - 1));
    // Behind the modes and outputs of the channels, which it locks.
    tim.bdtr().write_value(BdtrAdv(BDTR_OFF));
    tim.egr().write(|w| w.set_ug(true));
    tim.cr1().modify(|w| w.set_cen(true));
    pins.legs.connect();
    let mut stop = Flex::new(pins.stop);
    // Alternate function 1 of PE15 is the timer's break input.
    stop.set_as_af_unchecked(1, AfType::input(Pull::Down));
    core::mem::forget(stop);
    let mut fault = Flex::new(pins.fault);
    // Alternate function 1 of PE6 is its second one.
    fault.set_as_af_unchecked(1, AfType::input(Pull::Up));
    core::mem::forget(fault);
    // A wire that is off is a gate that never opens.
    core::mem::forget(Input::new(pins.gate, Pull::Down));
}

/// What broke before is forgotten: before driving begins.
#[inline(always)]
pub(crate) fn forget() {
    // Zero clears a flag, one does not touch it.
    pac::TIM1.sr().write(|w| w.0 = !(STOP | BRIDGE | CHIP));
}

/// Enables bridges or amplifiers, or disables them.
#[inline(always)]
pub(crate) fn enable(enable: bool) {
    pac::GPIOF.bsrr().write(|w| w.0 = if enable { ENABLE_SET } else { ENABLE_RESET });
}

/// Outputs on, once, when the bridges are awake: nothing else undoes a break, however short it was. They stay off if the emergency stop
/// was pressed since [`forget`] or the chip failed, and the timer does not take it while any of the three still breaks.
#[inline(always)]
pub(crate) fn on() {
    if pac::TIM1.sr().read().0 & (STOP | CHIP) == 0 {
        pac::TIM1.sr().write(|w| w.0 = !BRIDGE);
        pac::TIM1.bdtr().write_value(BdtrAdv(BDTR_ON));
        DRIVEN.store(true, Ordering::Relaxed);
    }
}

/// Outputs off, whatever the enable line is, and the compare values back to no voltage.
#[inline(always)]
pub(crate) fn rest() {
    // From here on the current loop's interrupt, which may come between any two of these, writes no compare value.
    DRIVEN.store(false, Ordering::Relaxed);
    compiler_fence(Ordering::SeqCst);
    pac::TIM1.bdtr().write_value(BdtrAdv(BDTR_OFF));
    for channel in legs::CHANNELS {
        pac::TIM1.ccr(channel).write(|w| w.set_ccr(MIDDLE));
    }
}

/// What turned the outputs off since [`forget`]: the stop, a bridge's fault output, or supply, clock or core of the chip, which is also what
/// leaves no mark. A press of the stop takes the bridges' supply, too, and they report it; so does a failing supply: what the others follow
/// from comes first.
pub(crate) fn cut() -> Cut {
    let flags = pac::TIM1.sr().read().0;
    let by_stop = flags & STOP != 0;
    let fault = if flags & (CHIP | BRIDGE) == BRIDGE { Fault::BridgeFailed } else { Fault::ChipFailed };
    Cut { by_stop, fault: if by_stop { None } else { Some(fault) } }
}

/// Everything off: enable line, outputs, and the compare values back to no voltage.
#[inline(always)]
pub(crate) fn off() {
    enable(false);
    rest();
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
