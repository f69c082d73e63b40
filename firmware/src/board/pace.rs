//! The 1 kHz timer of the tick, and the bell by which its interrupt wakes a task.
//!
//! The tick may not touch an executor (that takes a critical section, and the tick is above all of them). It pends an
//! unused interrupt of lower priority instead, one store, and that one signals.

use cortex_m::peripheral::NVIC;
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::{Peri, pac, peripherals::TIM6, timer::low_level::Timer};
use embassy_sync::{blocking_mutex::raw::CriticalSectionRawMutex, signal::Signal};

use super::{clocks::TIMERS_HZ, deadman};

/// The control period that the timer makes, s.
pub(crate) const PERIOD_S: f64 = 0.001;
/// Timer counts in a period: 60 MHz, so that the counter shows how long a tick took to 17 ns.
const COUNTS: u32 = TIMERS_HZ / PRESCALER / 1000;
const PRESCALER: u32 = 4;
const _: () = assert!(COUNTS <= 1 << 16 && COUNTS * PRESCALER * 1000 == TIMERS_HZ);

/// A packet went out, or a record is there.
static BELL: Signal<CriticalSectionRawMutex, ()> = Signal::new();

/// Starts the tick: from here on the interrupt runs, and has to.
pub(crate) fn start(timer: Peri<'static, TIM6>) {
    core::mem::forget(Timer::new(timer));
    interrupt::UART8.set_priority(Priority::P1);
    interrupt::TIM6_DAC.set_priority(Priority::P0);
    let tim = pac::TIM6;
    tim.psc().write_value((PRESCALER - 1) as u16);
    tim.arr().write(|w| w.set_arr((COUNTS - 1) as u16));
    tim.egr().write(|w| w.set_ug(true));
    tim.sr().write(|w| w.set_uif(false));
    tim.dier().write(|w| w.set_uie(true));
    // SAFETY: both handlers are there, and what they use is set up before this is called.
    unsafe {
        interrupt::UART8.enable();
        interrupt::TIM6_DAC.enable();
    }
    deadman::start();
    tim.cr1().modify(|w| w.set_cen(true));
}

/// Takes note that the tick began.
#[inline(always)]
pub(crate) fn acknowledge() {
    deadman::wind();
    pac::TIM6.sr().write(|w| w.set_uif(false));
}

/// Whether the next tick is due already.
#[inline(always)]
pub(crate) fn due() -> bool {
    pac::TIM6.sr().read().uif()
}

/// Rings: whoever waits in [`rung`] goes on. One store; for the tick.
#[inline(always)]
pub(crate) fn ring() {
    NVIC::pend(pac::Interrupt::UART8);
}

pub(crate) async fn rung() {
    BELL.wait().await;
}

/// UART8 is not used as such; its interrupt is the bell.
#[unsafe(no_mangle)]
extern "C" fn UART8() {
    BELL.signal(());
}
