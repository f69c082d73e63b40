//! See `src/lock.rs`.
#![no_main]

use cohold_environments_fuzz::TARGETS;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| (TARGETS[3].1)(bytes));
