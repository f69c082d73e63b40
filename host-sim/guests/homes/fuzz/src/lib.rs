//! What the fuzz target does with an input: what two homes and a meeting place say to each other. `fuzz_targets/` hands it to libFuzzer
//! (`cargo xtask fuzz`); `tests/suite/fuzz.rs` of the package runs it wherever tests run.

#[path = "../../../../../protocol/fuzz/src/check.rs"]
pub mod check;

mod meetings;

/// A target: its name, and what it does with an input.
pub type Target = (&'static str, fn(&[u8]));

/// The fuzz target, by name.
pub const TARGETS: [Target; 1] = [("meetings", meetings::run)];
