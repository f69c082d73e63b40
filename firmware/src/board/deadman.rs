//! Dead man: without a tick for 2 ms the chip is reset, and with that its outputs are off, whatever the program does.
//!
//! The window watchdog (WWDG1, RM0433 §44) counts down and every tick winds it up as it begins, whatever the mode; at its end the
//! chip is reset. In reset all pins float, so that the resistors at the bridges pull their enable low. So it ends a tick that
//! hangs or never comes, an interrupt that masks it, and a processor that locked up. What it counts is made of the core's own
//! clock: the independent watchdog ([`crate::board::WATCHDOG_MS`]), which has an oscillator of its own, stays.
//!
//! It is started with the tick, at every start, armed or not: nothing but a reset stops it, and a state that is the same in every
//! run is the one that is tried in every run. A tick of 1 ms may last to the end of the next one's period ([`cohold_core::safety::Fault::TickOverrun`]
//! tells of it) and not longer. Whoever erases or programs flash goes on being preempted by the tick. A debugger that halts the
//! processor halts it and the independent watchdog, too. No lower edge of the window is set: ticks that come too often are the supervisor's to notice.
//!
//! **Limit**: below 2.7 V the window watchdog does not work at this core voltage (ES0392 §2.2.23). The supply's break has turned the outputs off by
//! then, at 2.76 V ([`super::breaks`]).

use embassy_stm32::pac;

use super::clocks::PERIPHERALS_HZ;

/// Clocks of a count at the finest prescaler.
const CLOCKS: u32 = 4096;
/// Counts that are less than 2 ms: 58, which are 1.98 ms.
const COUNTS: u32 = PERIPHERALS_HZ / CLOCKS / 500;
/// Running, and so many counts to go until bit 6 falls.
const WOUND: u32 = 1 << 7 | 0x40 | (COUNTS - 1);
const _: () = assert!(COUNTS <= 64, "the counter has 6 bits until it resets");
const _: () = assert!(
    (COUNTS - 1) * CLOCKS / (PERIPHERALS_HZ / 10_000) >= 19,
    "at least 1.9 ms: ticks come each millisecond or more often"
);

/// Starts it: from here on ticks must come.
pub(crate) fn start() {
    // It resets the whole chip and not the processor alone; set before it runs (RM0433 §8.7.6).
    pac::RCC.gcr().modify(|w| w.set_ww1rsc(true));
    pac::RCC.apb3enr().modify(|w| w.set_wwdg1en(true));
    pac::DBGMCU.apb3fzr1().modify(|w| w.set_wwdg1(true));
    pac::DBGMCU.apb4fzr1().modify(|w| w.set_iwdg1(true));
    // Prescaler 1, and a window as wide as the counter.
    pac::WWDG1.cfr().write(|w| w.set_w(0x7F));
    wind();
}

/// Winds it up; for the tick.
#[inline(always)]
pub(crate) fn wind() {
    pac::WWDG1.cr().write(|w| w.0 = WOUND);
}
