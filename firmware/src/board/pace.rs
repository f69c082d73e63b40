//! The timer of the tick, and the bell by which its interrupt wakes a task.
//!
//! Ticks begin at the same place of a PWM period, behind the current loop's interrupt ([`BEHIND_UPDATE`]), at whatever rate the scene
//! asks for ([`set`]).
//!
//! The tick may not touch an executor (that takes a critical section, and the tick is above all of them). It pends an
//! unused interrupt of lower priority instead, one store, and that one signals. It also counts how long the tick took
//! ([`TIMES`]), from what the tick left of two clocks: its own timer, which says how late it began, and the core's counter of cycles.

use core::sync::atomic::{AtomicU16, AtomicU32, Ordering};

use cortex_m::peripheral::{DWT, NVIC};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::peripherals::{TIM6, TIM7};
use embassy_stm32::{Peri, pac, timer::low_level::Timer};
use embassy_sync::{blocking_mutex::raw::CriticalSectionRawMutex, signal::Signal};

use cohold_core::device::current::PWM_HZ;
use firmware_parts::rate::Rate;
use firmware_parts::record::SENT;
use firmware_parts::times::{Load, Times, Took};

use super::clocks::{CORE_HZ, TIMERS_HZ};
use super::{current, deadman, switch};

/// Timer counts in a millisecond: 60 MHz, so that the counter shows how long a tick took to 17 ns.
const COUNTS: u32 = TIMERS_HZ / PRESCALER / 1000;
const PRESCALER: u32 = 4;
/// From an update of the bridges' timer, whose periods fit 4 to 20 times into the tick's, to a tick: 4 µs. By then the current loop's interrupt has
/// ended, the next one is 47 µs away, and so it stays: the two timers have one clock.
const BEHIND_UPDATE: u32 = COUNTS / 250;
/// Set when the bridges' timer updates.
const UPDATED: u32 = 1;
/// Looks for that: more than a period of it.
const LOOKS: u32 = 10_000;
const _: () = assert!(COUNTS <= 1 << 16 && COUNTS * PRESCALER * 1000 == TIMERS_HZ);
/// Counts a millisecond of the timer that goes on while a debugger halts the processor. More than 2 ms of them do not lie between two ticks of a
/// processor that was not halted: after 1.98 ms without a tick the chip is reset ([`deadman`]).
const HALTS_PER_MS: u16 = 10;

/// One run of the current loop's interrupt, in cycles.
pub(crate) struct Run {
    pub(crate) began: u32,
    pub(crate) ended: u32,
    /// Counts of the timer since the update; one later than half a period looks as much too early.
    pub(crate) late: u32,
    /// It did not run in the period before.
    pub(crate) first: bool,
}

/// Times of the tick since the start, and of the current loop.
pub(crate) static TIMES: Times = Times::none();
pub(crate) static LOOP_TIMES: Times = Times::none();
/// What both have of the processor.
pub(crate) static LOAD: Load = Load::none();
pub(crate) static LOOP_LOAD: Load = Load::none();
/// The last run of the current loop that was counted.
static COUNTED: AtomicU32 = AtomicU32::new(0);
/// Ticks a millisecond.
static PER_MS: AtomicU32 = AtomicU32::new(Rate::Khz1.per_ms());
/// What the last tick left about itself: its number, when it began and ended, and in one word how late it was in its timer's counts, its flags,
/// and the ticks a millisecond by which it came.
static TOOK: [AtomicU32; 4] = [const { AtomicU32::new(0) }; 4];

/// When the last tick began, by the timer that goes on in a halt.
static BEGAN: AtomicU16 = AtomicU16::new(0);
/// The last tick in which a packet went out, and the last of these that somebody was woken for.
static SENT_IN: AtomicU32 = AtomicU32::new(0);
static TOLD: AtomicU32 = AtomicU32::new(0);
/// A packet went out.
static BELL: Signal<CriticalSectionRawMutex, ()> = Signal::new();

/// Ticks a millisecond, as the tick has them now.
pub(crate) fn per_ms() -> u32 {
    PER_MS.load(Ordering::Relaxed)
}

/// So many ticks from here on; for the tick, as it begins: the counter is far from the shortest period's end, and goes on with the PWM.
#[inline(always)]
pub(crate) fn set(rate: Rate) {
    PER_MS.store(rate.per_ms(), Ordering::Relaxed);
    pac::TIM6.arr().write(|w| w.set_arr((COUNTS / rate.per_ms() - 1) as u16));
}

/// Starts the tick: from here on the interrupt runs, and has to.
pub(crate) fn start(timer: Peri<'static, TIM6>, halts: Peri<'static, TIM7>, rate: Rate) {
    core::mem::forget(Timer::new(timer));
    core::mem::forget(Timer::new(halts));
    pac::TIM7.psc().write_value((TIMERS_HZ / 1000 / u32::from(HALTS_PER_MS) - 1) as u16);
    pac::TIM7.egr().write(|w| w.set_ug(true));
    pac::TIM7.cr1().modify(|w| w.set_cen(true));
    interrupt::UART8.set_priority(Priority::P2);
    interrupt::TIM6_DAC.set_priority(Priority::P1);
    let tim = pac::TIM6;
    tim.psc().write_value((PRESCALER - 1) as u16);
    set(rate);
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
    COUNTED.store(current::runs(), Ordering::Relaxed);
    deadman::start();
    // Nothing may come between the update and the start; for 50 µs at the most, unless the bridges' timer stands still.
    cortex_m::interrupt::free(|_| {
        pac::TIM1.sr().write(|w| w.0 = !UPDATED);
        let _ = (0..LOOKS).any(|_| pac::TIM1.sr().read().0 & UPDATED != 0);
        tim.cnt().write(|w| w.set_cnt((COUNTS / rate.per_ms() - BEHIND_UPDATE) as u16));
        tim.cr1().modify(|w| w.set_cen(true));
    });
}

/// The beginning of a tick.
#[derive(Clone, Copy)]
pub(crate) struct Began {
    cycle: u32,
    late: u16,
    per_ms: u32,
    /// The tick's timer stood still since the last one, for 2 ms or more: a debugger halted the processor. Of 3,000 halts of any length one is not
    /// seen, that of a multiple of 6.5536 s.
    pub(crate) stood: bool,
}

/// Takes note that the tick began.
#[inline(always)]
pub(crate) fn begin() -> Began {
    let late = pac::TIM6.cnt().read().cnt();
    let now = pac::TIM7.cnt().read().cnt();
    let since = now.wrapping_sub(BEGAN.load(Ordering::Relaxed));
    BEGAN.store(now, Ordering::Relaxed);
    let began = Began { late, per_ms: per_ms(), cycle: DWT::cycle_count(), stood: since > 2 * HALTS_PER_MS };
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
    let words =
        [tick, began.cycle, DWT::cycle_count(), u32::from(began.late) | u32::from(flags) << 16 | began.per_ms << 24];
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

/// What the bell does after every tick: looks at the hold-to-run switch, counts times, and wakes who waits.
pub(crate) fn after_tick() {
    switch::look();
    let [tick, began, ended, rest] = TOOK.each_ref().map(|word| word.load(Ordering::Relaxed));
    // A tick that came between is counted when it rings itself.
    if TOOK[0].load(Ordering::Relaxed) == tick {
        let delay = (rest & 0xFFFF) * (CORE_HZ / (TIMERS_HZ / PRESCALER));
        let took = Took { tick, flags: (rest >> 16) as u8, delay, began, ended };
        let per_ms = (rest >> 24).max(1);
        TIMES.see(&took, CORE_HZ / 1000 / per_ms);
        LOAD.see(ended.wrapping_sub(began));
        count_runs(&took, current::PERIODS / per_ms);
        if tick.is_multiple_of(1000 * per_ms) {
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

/// Counts the runs of the current loop since the last time, in this tick of so many PWM periods. What the ring has lost is not counted.
fn count_runs(tick: &Took, periods: u32) {
    let last = current::runs();
    let mut run = COUNTED.load(Ordering::Relaxed);
    let mut follows = last.wrapping_sub(run) < current::RING;
    if !follows {
        run = last.wrapping_sub(periods);
    }
    while run != last {
        run = run.wrapping_add(1);
        let ran = current::run(run);
        let took = Took { delay: ran.late * (CORE_HZ / TIMERS_HZ), began: ran.began, ended: ran.ended, ..*tick };
        LOOP_TIMES.see_run(&took, follows && !ran.first, CORE_HZ / PWM_HZ);
        LOOP_LOAD.see(ran.ended.wrapping_sub(ran.began));
        follows = true;
    }
    COUNTED.store(last, Ordering::Relaxed);
}
