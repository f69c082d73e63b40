//! The fuzz targets of cohold-page. `fuzz_targets/` hands them to libFuzzer (`cargo xtask fuzz`). The live page is no library: what its
//! target does stands in `page.rs`, is compiled with the page itself, and is public in a build for the fuzzer alone.
//! `tests/inside/fuzz.rs` of the package runs it wherever tests run.

/// A target: its name, and what it does with an input.
pub type Target = (&'static str, fn(&[u8]));

/// Every fuzz target, by name.
pub const TARGETS: [Target; 1] = [("page", cohold_page::page_hears)];
