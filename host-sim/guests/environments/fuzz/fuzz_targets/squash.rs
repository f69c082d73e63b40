//! See `src/squash.rs`.
#![no_main]

use cohold_environments_fuzz::TARGETS;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| (TARGETS[6].1)(bytes));
