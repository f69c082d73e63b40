//! Instructions of every numerical choice on the processor of the board, a Cortex-M7 with its double-precision FPU.
//!
//! The cases are those that callgrind counts on a PC (`host-sim/src/accuracy/cases`, the same files). Here they run on
//! QEMU's mps2-an500 with `-icount`: the virtual clock moves by a fixed time with every instruction, so a timer counts
//! instructions, exactly and the same on every run. What the timer shows between two readings with nothing between them
//! is taken off; what one instruction is in timer ticks is measured on a thousand `nop`s.
//!
//!     cargo run --release > ../../host-sim/src/accuracy/instructions-cortex-m7.txt
//!
//! Needs `qemu-system-arm` (Debian's 7.2 will do). Instructions, not cycles: QEMU has no pipeline and no memory latency.
#![no_std]
#![no_main]

extern crate alloc;

#[path = "../../../host-sim/src/accuracy/cases/mod.rs"]
#[allow(dead_code, missing_docs, reason = "host-sim uses and documents the rest")]
mod cases;
mod heap;

use alloc::string::String;
use alloc::vec::Vec;
use core::fmt::Write;
use core::panic::PanicInfo;
use core::sync::atomic::{AtomicU32, Ordering};

use cases::{Case, Meter};
use cortex_m::peripheral::{Peripherals, SYST, syst::SystClkSource};
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprint, hprintln};
use haptic_core::scalar::Fixed;

#[global_allocator]
static HEAP: heap::Heap = heap::Heap::new();

/// Instructions of all counted calls of a case.
static COUNT: AtomicU32 = AtomicU32::new(0);
/// Ticks of the timer in a thousand instructions.
static THOUSAND: AtomicU32 = AtomicU32::new(0);
/// Ticks between two readings with nothing between them.
static EMPTY: AtomicU32 = AtomicU32::new(0);
/// The timer counts down in 24 bits.
const MASK: u32 = 0x00ff_ffff;

/// The timer of the processor.
struct Timer;

impl Timer {
    #[inline(always)]
    fn between<O>(body: impl FnOnce() -> O) -> (O, u32) {
        let before = SYST::get_current();
        let out = body();
        let after = SYST::get_current();
        (out, before.wrapping_sub(after) & MASK)
    }
}

/// The call that is counted, not inlined into the readings.
#[inline(never)]
fn measured_call<I, O>(body: &mut impl FnMut(I) -> O, input: I) -> O {
    body(input)
}

impl Meter for Timer {
    fn call<I, O>(body: &mut impl FnMut(I) -> O, input: I) -> O {
        let (out, ticks) = Self::between(|| measured_call(body, input));
        let (ticks, thousand) = (ticks - EMPTY.load(Ordering::Relaxed), THOUSAND.load(Ordering::Relaxed));
        // A timer tick is a fraction of an instruction: the nearest whole number of them is exact.
        let instructions = (u64::from(ticks) * 1000 + u64::from(thousand / 2)) / u64::from(thousand);
        COUNT.store(COUNT.load(Ordering::Relaxed) + instructions as u32, Ordering::Relaxed);
        out
    }
}

/// Timer ticks of a thousand instructions.
fn thousand() -> u32 {
    // SAFETY: `nop` does nothing.
    let ((), ticks) = Timer::between(|| unsafe { core::arch::asm!(".rept 1000", "nop", ".endr") });
    ticks - EMPTY.load(Ordering::Relaxed)
}

/// Instructions per call of every case.
fn count(cases: impl Iterator<Item = Case>) -> Vec<(String, u32)> {
    cases
        .map(|case| {
            COUNT.store(0, Ordering::Relaxed);
            (case.replay)();
            let calls = case.calls as u32;
            (case.name, (COUNT.load(Ordering::Relaxed) + calls / 2) / calls)
        })
        .collect()
}

#[entry]
fn main() -> ! {
    if let Some(mut peripherals) = Peripherals::take() {
        peripherals.SYST.set_clock_source(SystClkSource::Core);
        peripherals.SYST.set_reload(MASK);
        peripherals.SYST.clear_current();
        peripherals.SYST.enable_counter();
    }
    let ((), empty) = Timer::between(|| ());
    EMPTY.store(empty, Ordering::Relaxed);
    THOUSAND.store(thousand(), Ordering::Relaxed);
    let columns =
        [count(cases::all::<f32, Timer>()), count(cases::all::<f64, Timer>()), count(cases::all::<Fixed, Timer>())];
    hprintln!("# Instructions per call, Cortex-M7 (thumbv7em, QEMU), release build; tick/… per tick of a whole peer.");
    hprintln!("# Counted by `cargo run --release` in tests/count. Instructions, not cycles.");
    hprintln!("# {:<32} {:>7} {:>7} {:>7}", "case", "f32", "f64", "i32f32");
    let [f32, f64, fixed] = &columns;
    for ((a, b), c) in f32.iter().zip(f64).zip(fixed) {
        let mut line = String::new();
        let _ = write!(line, "{:<34} {:>7} {:>7} {:>7}", a.0, a.1, b.1, c.1);
        hprintln!("{}", line);
    }
    debug::exit(debug::EXIT_SUCCESS);
    loop {
        cortex_m::asm::wfi();
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    hprint!("{}\n", info);
    debug::exit(debug::EXIT_FAILURE);
    loop {
        cortex_m::asm::wfi();
    }
}
