//! What the fuzz targets do with an input, one file each: files and answers that others wrote, as a PC reads them. `fuzz_targets/`
//! hands them to libFuzzer (`cargo xtask fuzz`); `tests/suite/fuzz.rs` of the package runs them wherever tests run.

#[path = "../../../../protocol/fuzz/src/check.rs"]
pub mod check;

mod answers;
mod recordings;
mod scenes;

/// A target: its name, and what it does with an input.
pub type Target = (&'static str, fn(&[u8]));

/// Every fuzz target, by name.
pub const TARGETS: [Target; 3] = [("recordings", recordings::run), ("answers", answers::run), ("scenes", scenes::run)];
