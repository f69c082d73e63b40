//! Instructions of every numerical choice on the processor of the board, a Cortex-M7 with its double-precision FPU.
//!
//! The cases are those that callgrind counts on a PC (`cohold-cases`). Here they run on
//! QEMU, where a timer counts instructions (`lib.rs`). `cargo xtask count` runs this and compares.
//!
//! Needs `qemu-system-arm` (Debian's 7.2 will do). Instructions, not cycles: QEMU has no pipeline and no memory latency.
#![no_std]
#![no_main]

extern crate alloc;

mod heap;

use alloc::string::String;
use alloc::vec::Vec;
use core::fmt::Write;
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use cohold_cases::{Case, Meter};
use cohold_core::num::{Fixed, Scalar};
use cohold_laws::EveryLaw;

#[global_allocator]
static HEAP: heap::Heap = heap::Heap::new();

/// Instructions of all counted calls of a case.
static COUNT: AtomicU32 = AtomicU32::new(0);
/// The timer of the processor.
struct Timer;

/// The call that is counted, not inlined into the readings.
#[inline(never)]
fn measured_call<I, O>(body: &mut impl FnMut(I) -> O, input: I) -> O {
    body(input)
}

impl Meter for Timer {
    fn call<I, O>(body: &mut impl FnMut(I) -> O, input: I) -> O {
        let (out, instructions) = counting::counted(|| measured_call(body, input));
        COUNT.store(COUNT.load(Ordering::Relaxed) + instructions, Ordering::Relaxed);
        out
    }
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

/// The FPU's square root has the bits of the one in software, which a PC computes: half a million numbers over all of f32.
fn square_roots_agree() -> bool {
    let numbers = (0..f32::INFINITY.to_bits()).step_by(4099).map(f32::from_bits);
    numbers.map(core::hint::black_box).all(|x| Scalar::sqrt(x).to_bits() == libm::sqrtf(x).to_bits())
}

#[entry]
fn main() -> ! {
    if !square_roots_agree() {
        hprintln!("the FPU's square root differs from libm's");
        counting::end(false);
    }
    counting::start();
    let columns = [
        count(cohold_cases::all::<f32, EveryLaw<f32>, Timer>()),
        count(cohold_cases::all::<f64, EveryLaw<f64>, Timer>()),
        count(cohold_cases::all::<Fixed, EveryLaw<Fixed>, Timer>()),
    ];
    hprintln!("# Instructions per call, Cortex-M7 (thumbv7em, QEMU), release build; tick/… per tick of a whole peer.");
    hprintln!("# Counted by `cargo xtask count`. Instructions, not cycles.");
    hprintln!("# {:<32} {:>7} {:>7} {:>7}", "case", "f32", "f64", "i32f32");
    let [f32, f64, fixed] = &columns;
    for ((a, b), c) in f32.iter().zip(f64).zip(fixed) {
        let mut line = String::new();
        let _ = write!(line, "{:<34} {:>7} {:>7} {:>7}", a.0, a.1, b.1, c.1);
        hprintln!("{}", line);
    }
    counting::end(true)
}
