//! See `src/page.rs`.
#![no_main]

use cohold_page_fuzz::TARGETS;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| (TARGETS[0].1)(bytes));
