//! The machine that counts: QEMU's mps2-an500 with `-icount`, where the virtual clock moves by a fixed time with every
//! instruction, so a timer counts instructions, exactly and the same on every run.
//!
//! What the timer shows between two readings with nothing between them is taken off; what one instruction is in timer ticks
//! is measured on a thousand `nop`s. The timer has 24 bits, 650,000 instructions: an exception counts its rounds, which adds some
//! twenty instructions to each.

#![no_std]

use core::panic::PanicInfo;
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::{Peripherals, SYST, syst::SystClkSource};
use cortex_m_rt::exception;
use cortex_m_semihosting::{debug, hprint};

/// Ticks of the timer in a thousand instructions.
static THOUSAND: AtomicU32 = AtomicU32::new(0);
/// Ticks between two readings with nothing between them.
static EMPTY: AtomicU32 = AtomicU32::new(0);
/// The timer counts down in 24 bits.
const MASK: u32 = 0x00ff_ffff;

/// Rounds of the timer.
static ROUNDS: AtomicU32 = AtomicU32::new(0);

#[exception]
fn SysTick() {
    ROUNDS.fetch_add(1, Ordering::Relaxed);
}

/// Timer ticks since the start.
#[inline(always)]
fn now() -> u64 {
    loop {
        let rounds = ROUNDS.load(Ordering::Relaxed);
        let left = SYST::get_current();
        if rounds == ROUNDS.load(Ordering::Relaxed) {
            return u64::from(rounds) << 24 | u64::from(MASK - left);
        }
    }
}

/// Starts the timer and measures what it takes itself; once, before anything is counted.
pub fn start() {
    if let Some(mut peripherals) = Peripherals::take() {
        peripherals.SYST.set_clock_source(SystClkSource::Core);
        peripherals.SYST.set_reload(MASK);
        peripherals.SYST.clear_current();
        peripherals.SYST.enable_interrupt();
        peripherals.SYST.enable_counter();
    }
    let ((), empty) = between(|| ());
    EMPTY.store(empty, Ordering::Relaxed);
    // SAFETY: `nop` does nothing.
    let ((), ticks) = between(|| unsafe { core::arch::asm!(".rept 1000", "nop", ".endr") });
    THOUSAND.store(ticks - empty, Ordering::Relaxed);
}

#[inline(always)]
fn between<O>(body: impl FnOnce() -> O) -> (O, u32) {
    let before = now();
    let out = body();
    (out, (now() - before) as u32)
}

/// What `body` gives, and the instructions that took.
#[inline(always)]
pub fn counted<O>(body: impl FnOnce() -> O) -> (O, u32) {
    let (out, ticks) = between(body);
    let (ticks, thousand) = (ticks - EMPTY.load(Ordering::Relaxed), THOUSAND.load(Ordering::Relaxed));
    // A timer tick is a fraction of an instruction: the nearest whole number of them is exact.
    let instructions = (u64::from(ticks) * 1000 + u64::from(thousand / 2)) / u64::from(thousand);
    (out, instructions as u32)
}

/// Ends the emulator with success or failure.
pub fn end(success: bool) -> ! {
    debug::exit(if success { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE });
    loop {
        cortex_m::asm::wfi();
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    hprint!("{}\n", info);
    end(false)
}
