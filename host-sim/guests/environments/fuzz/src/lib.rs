//! What the fuzz targets do with an input, one file each. `fuzz_targets/` hands them to libFuzzer, which steers by coverage
//! (`cargo xtask fuzz`); `tests/suite/fuzz.rs` of the package runs them over seeded bytes and over the corpus wherever tests run.
//!
//! Where a target has peers and a network, the input is a script: whose turn it is, how much time passes, what arrives, is lost
//! or comes twice, who crashes. Whatever it says, what must always be true is asserted after every step; then the network is
//! well again, and what must become true in the end is asserted, too.

#[path = "../../../../../protocol/fuzz/src/check.rs"]
pub mod check;
#[path = "../../../../../protocol/fuzz/src/net.rs"]
mod net;
#[path = "../../../../../protocol/fuzz/src/script.rs"]
mod script;

mod cooperative;
mod download;
mod lock;
mod records;
mod ring;
mod roles;
mod squash;

/// A target: its name, and what it does with an input.
pub type Target = (&'static str, fn(&[u8]));

/// Every fuzz target, by name.
pub const TARGETS: [Target; 7] = [
    ("records", records::run),
    ("download", download::run),
    ("roles", roles::run),
    ("lock", lock::run),
    ("ring", ring::run),
    ("cooperative", cooperative::run),
    ("squash", squash::run),
];
