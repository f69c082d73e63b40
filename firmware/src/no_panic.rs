//! Two proofs about the tick and the current loop: they cannot panic, and all of their code lies in ITCM. This program links only if both
//! hold.
//!
//! It holds the two interrupts' own lines (`tick.rs`, `board/current.rs` and what they use) and starts at them; the linker drops what cannot be
//! reached from there. If the panic handler is left, so is its call of a function that does not exist, and the link fails
//! with that name. `no_panic.x` has a place for code in ITCM only, as memory.x fills it: code that is left and not there makes
//! the link fail with its own name. The program is never run.
//!
//! `cargo xtask test --only no-panic` links it, and once more with the feature `planted-panic`, which must fail on both counts: a proof
//! that cannot fail proves nothing.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![allow(dead_code, reason = "tasks use the rest")]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("the proof is for the board: cargo xtask test --only no-panic");
}

#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod boards;
#[cfg(target_os = "none")]
mod tick;

#[cfg(target_os = "none")]
mod proof {
    use core::panic::PanicInfo;

    unsafe extern "C" {
        /// Never defined, so that a program that may call it does not link.
        fn a_panic_is_reachable_from_the_tick() -> !;
    }

    #[panic_handler]
    fn panic(_: &PanicInfo<'_>) -> ! {
        // SAFETY: never linked, so never run.
        unsafe { a_panic_is_reachable_from_the_tick() }
    }

    unsafe extern "C" {
        #[cfg(not(any(feature = "three-axes", feature = "moteus")))]
        fn ADC();
        fn TIM6_DAC();
    }

    /// The start of the program.
    #[unsafe(no_mangle)]
    #[unsafe(link_section = ".itcm.both")]
    extern "C" fn both() {
        // SAFETY: never run.
        unsafe {
            #[cfg(not(any(feature = "three-axes", feature = "moteus")))]
            ADC();
            TIM6_DAC();
        }
    }

    /// The proof's program with a mistake in it, and not in ITCM: the start of the program with the feature
    /// `planted-panic`.
    #[cfg(feature = "planted-panic")]
    #[unsafe(no_mangle)]
    extern "C" fn planted() -> u32 {
        both();
        let table = [1, 2, 3, 4];
        table[usize::from(cortex_m::peripheral::DWT::cycle_count() as u16)]
    }
}
