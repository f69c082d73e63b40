//! See `src/answers.rs`.
#![no_main]

use cohold_live_fuzz::TARGETS;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| (TARGETS[1].1)(bytes));
