//! See `src/meetings.rs`.
#![no_main]

use haptic_live_fuzz::TARGETS;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| (TARGETS[3].1)(bytes));
