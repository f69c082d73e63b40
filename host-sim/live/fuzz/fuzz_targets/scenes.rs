//! See `src/scenes.rs`.
#![no_main]

use cohold_live_fuzz::TARGETS;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| (TARGETS[2].1)(bytes));
