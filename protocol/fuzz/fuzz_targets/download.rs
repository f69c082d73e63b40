//! See `src/download.rs`.
#![no_main]

use haptic_protocol_fuzz::TARGETS;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| (TARGETS[7].1)(bytes));
