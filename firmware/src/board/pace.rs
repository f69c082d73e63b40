//! The 1 kHz timer of the tick, and the bell by which its interrupt wakes a task.
//!
//! Ticks begin at the same place of a PWM period, behind the current loop's interrupt ([`BEHIND_UPDATE`]).
//!
//! The tick may not touch an executor (that takes a critical section, and the tick is above all of them). It pends an
//! unused interrupt of lower priority instead, one store, and that one signals. It also counts how long the tick took
//! ([`TIMES`]), from what the tick left of two clocks: its own timer, which says how late it began, and the core's counter of cycles.

use core::sync::atomic::{AtomicU16, AtomicU32, Ordering};

use cortex_m::peripheral::{DWT, NVIC};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::{Peri, pac, peripherals::TIM6, timer::low_level::Timer};
use embassy_sync::{blocking_mutex::raw::CriticalSectionRawMutex, signal::Signal};

use firmware_parts::record::SENT;
use firmware_parts::times::{Load, Times, Took};
use haptic_core::device::current::PWM_HZ;

use super::clocks::{CORE_HZ, TIMERS_HZ};
use super::current::{self, Run};
use super::{deadman, switch};

/// The control period that the timer makes, s.
pub(crate) const PERIOD_S: f64 = 0.001;
/// Timer counts in a period: 60 MHz, so that the counter shows how long a tick took to 17 ns.
const COUNTS: u32 = TIMERS_HZ / PRESCALER / 1000;
const PRESCALER: u32 = 4;
/// From an update of the bridges' timer, whose periods fit 20 times into the tick's, to a tick: 4 µs. By then the current loop's interrupt has
/// ended, the next one is 47 µs away, and so it stays: the two timers have one clock.
const BEHIND_UPDATE: u32 = COUNTS / 250;
/// Set when the bridges' timer updates.
const UPDATED: u32 = 1;
/// Looks for that: more than a period of it.
const LOOKS: u32 = 10_000;
const _: () = assert!(COUNTS <= 1 << 16 && COUNTS * PRESCALER * 1000 == TIMERS_HZ);

/// Times of the tick since the start, and of the current loop.
pub(crate) static TIMES: Times = Times::none();
pub(crate) static LOOP_TIMES: Times = Times::none();
/// What both have of the processor.
pub(crate) static LOAD: Load = Load::none();
pub(crate) static LOOP_LOAD: Load = Load::none();
/// The last run of the current loop that was counted.
static COUNTED: AtomicU32 = AtomicU32::new(0);
/// What the last tick left about itself: its number, when it began and ended, how late it was in its timer's counts with its flags above.
static TOOK: [AtomicU32; 4] = [const { AtomicU32::new(0) }; 4];

/// When the last tick was due by the time driver's counter, µs, which goes on while a debugger halts the processor.
static DUE_US: AtomicU16 = AtomicU16::new(0);
/// The last tick in which a packet went out, and the last of these that somebody was woken for.
static SENT_IN: AtomicU32 = AtomicU32::new(0);
static TOLD: AtomicU32 = AtomicU32::new(0);
/// A packet went out.
static BELL: Signal<CriticalSectionRawMutex, ()> = Signal::new();

/// Starts the tick: from here on the interrupt runs, and has to.
pub(crate) fn start(timer: Peri<'static, TIM6>) {
    core::mem::forget(Timer::new(timer));
    interrupt::UART8.set_priority(Priority::P2);
    interrupt::TIM6_DAC.set_priority(Priority::P1);
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
    // SAFETY: nobody else holds the core's counter, which runs from here on.
    let mut processor = unsafe { cortex_m::Peripherals::steal() };
    processor.DCB.enable_trace();
    DWT::unlock();
    processor.DWT.enable_cycle_counter();
    deadman::start();
    // Nothing may come between the update and the start; for 50 µs at the most, unless the bridges' timer stands still.
    cortex_m::interrupt::free(|_| {
        pac::TIM1.sr().write(|w| w.0 = !UPDATED);
        let _ = (0..LOOKS).any(|_| pac::TIM1.sr().read().0 & UPDATED != 0);
        tim.cnt().write(|w| w.set_cnt((COUNTS - BEHIND_UPDATE) as u16));
        tim.cr1().modify(|w| w.set_cen(true));
    });
}

/// The beginning of a tick.
#[derive(Clone, Copy)]
pub(crate) struct Began {
    cycle: u32,
    late: u16,
    /// The tick's timer stood still since the last one, for more than 100 µs. Not seen if it was for a multiple of the time driver's round, 65.536 ms.
    pub(crate) stood: bool,
}

/// Takes note that the tick began.
#[inline(always)]
pub(crate) fn begin() -> Began {
    let late = pac::TIM6.cnt().read().cnt();
    let due_us = (pac::TIM5.cnt().read() as u16).wrapping_sub(late / (COUNTS / 1000) as u16);
    let since_us = due_us.wrapping_sub(DUE_US.load(Ordering::Relaxed));
    DUE_US.store(due_us, Ordering::Relaxed);
    let began = Began { late, cycle: DWT::cycle_count(), stood: since_us.wrapping_sub(900) > 200 };
    pac::TIM6.sr().write(|w| w.set_uif(false));
    began
}

/// Whether the next tick is due already.
#[inline(always)]
pub(crate) fn due() -> bool {
    pac::TIM6.sr().read().uif()
}

/// Takes note that the tick ended, and rings: whoever waits in [`rung`] goes on, if a packet went out. A few stores; for the tick.
#[inline(always)]
pub(crate) fn end(began: Began, tick: u32, flags: u8) {
    let words = [tick, began.cycle, DWT::cycle_count(), u32::from(began.late) | u32::from(flags) << 16];
    for (place, word) in TOOK.iter().zip(words) {
        place.store(word, Ordering::Relaxed);
    }
    if flags & SENT != 0 {
        SENT_IN.store(tick, Ordering::Relaxed);
    }
    NVIC::pend(pac::Interrupt::UART8);
}

pub(crate) async fn rung() {
    BELL.wait().await;
}

/// UART8 is not used as such; its interrupt is the bell.
#[unsafe(no_mangle)]
extern "C" fn UART8() {
    switch::look();
    let [tick, began, ended, rest] = TOOK.each_ref().map(|word| word.load(Ordering::Relaxed));
    // A tick that came between is counted when it rings itself.
    if TOOK[0].load(Ordering::Relaxed) == tick {
        let delay = (rest & 0xFFFF) * (CORE_HZ / (TIMERS_HZ / PRESCALER));
        let took = Took { tick, flags: (rest >> 16) as u8, delay, began, ended };
        TIMES.see(&took, CORE_HZ / 1000);
        LOAD.see(ended.wrapping_sub(began));
        count_runs(&took);
        if tick.is_multiple_of(1000) {
            LOAD.second();
            LOOP_LOAD.second();
        }
    }
    let sent = SENT_IN.load(Ordering::Relaxed);
    if sent != TOLD.load(Ordering::Relaxed) {
        TOLD.store(sent, Ordering::Relaxed);
        BELL.signal(());
    }
}

/// Counts the runs of the current loop since the last time, in this tick. What the ring has lost is not counted.
fn count_runs(tick: &Took) {
    let last = current::runs();
    let mut run = COUNTED.load(Ordering::Relaxed);
    let mut follows = last.wrapping_sub(run) < current::RING;
    if !follows {
        run = last.wrapping_sub(current::PERIODS);
    }
    while run != last {
        run = run.wrapping_add(1);
        let Run { began, ended, late, first } = current::run(run);
        let took = Took { delay: late * (CORE_HZ / TIMERS_HZ), began, ended, ..*tick };
        LOOP_TIMES.see_run(&took, follows && !first, CORE_HZ / PWM_HZ);
        LOOP_LOAD.see(ended.wrapping_sub(began));
        follows = true;
    }
    COUNTED.store(last, Ordering::Relaxed);
}
