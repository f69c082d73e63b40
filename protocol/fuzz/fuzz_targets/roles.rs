//! See `src/roles.rs`.
#![no_main]

use haptic_protocol_fuzz::TARGETS;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| (TARGETS[8].1)(bytes));
