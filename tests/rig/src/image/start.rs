//! The first instructions after a reset, and the end of a program that could panic.

use core::panic::PanicInfo;

use crate::{captures, clocks, pins, rig, serial};

// Coprocessors on, interrupts masked: one that is pending wakes the processor all the same, and is not taken. A fault is a new start.
core::arch::global_asm!(
    ".section .start, \"ax\", %progbits",
    ".global reset",
    ".global fail",
    ".thumb_func",
    "reset:",
    "cpsid i",
    "ldr r0, =0xE000ED88",
    "ldr r1, [r0]",
    "orr r1, r1, #0xF00000",
    "str r1, [r0]",
    "dsb",
    "isb",
    "bl begin",
    ".thumb_func",
    "fail:",
    "ldr r0, =0xE000ED0C",
    "ldr r1, =0x05FA0004",
    "str r1, [r0]",
    "dsb",
    "1: b 1b",
);

unsafe extern "C" {
    /// Never defined, so that a program that may call it does not link.
    fn a_panic_is_reachable_from_the_rig() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // SAFETY: never linked, so never run.
    unsafe { a_panic_is_reachable_from_the_rig() }
}

#[unsafe(no_mangle)]
extern "C" fn begin() -> ! {
    clocks::start();
    pins::start();
    captures::start();
    serial::start();
    rig::run()
}
