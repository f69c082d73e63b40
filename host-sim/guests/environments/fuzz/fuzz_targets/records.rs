//! See `src/records.rs`.
#![no_main]

use cohold_environments_fuzz::TARGETS;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| (TARGETS[0].1)(bytes));
