//! The proof that the tick cannot panic: this program links only if no panic is reachable from the interrupt.
//!
//! It holds the interrupt's own lines (`tick.rs` and what it uses), starts at the interrupt, and its panic handler calls a
//! function that does not exist. The linker drops what cannot be reached from the start; if the handler is left, so is its
//! call, and the link fails with the name of that function. The program is never run.
//!
//! `cargo xtask no-panic` links it, and once more with the feature `planted-panic`, which must fail: a proof that cannot
//! fail proves nothing.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![allow(dead_code, reason = "tasks use the rest")]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("the proof is for the board: cargo xtask no-panic");
}

#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod tick;

#[cfg(target_os = "none")]
mod proof {
    use core::panic::PanicInfo;

    unsafe extern "C" {
        /// Nowhere.
        fn a_panic_is_reachable_from_the_tick() -> !;
    }

    #[panic_handler]
    fn panic(_: &PanicInfo<'_>) -> ! {
        // SAFETY: never linked, so never run.
        unsafe { a_panic_is_reachable_from_the_tick() }
    }

    /// The tick with a mistake in it: the start of the program with the feature `planted-panic`.
    #[cfg(feature = "planted-panic")]
    #[unsafe(no_mangle)]
    extern "C" fn planted() -> u32 {
        unsafe extern "C" {
            fn TIM6_DAC();
        }
        // SAFETY: never run.
        unsafe { TIM6_DAC() }
        let table = [1, 2, 3, 4];
        table[usize::from(crate::board::encoders::read()[0].0)]
    }
}
