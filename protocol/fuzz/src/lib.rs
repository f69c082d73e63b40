//! What the fuzz targets do with an input, one file each. `fuzz_targets/` hands them to libFuzzer, which steers by coverage
//! (`cargo xtask fuzz`); `tests/suite/fuzz.rs` of the package runs them over seeded bytes and over the corpus wherever tests run.
//!
//! Where a target has peers and a network, the input is a script: whose turn it is, how much time passes, what arrives, is lost
//! or comes twice, who crashes. Whatever it says, what must always be true is asserted after every step; then the network is
//! well again, and what must become true in the end is asserted, too.

pub mod check;
#[allow(dead_code)] // Roles need all of it (host-sim/guests/environments/fuzz), a line does not.
mod net;
mod pair;
mod script;

mod lines;
mod link;
mod playout;
mod replay;
mod session;
mod wire;

/// A target: its name, and what it does with an input.
pub type Target = (&'static str, fn(&[u8]));

/// Every fuzz target, by name.
pub const TARGETS: [Target; 6] = [
    ("wire", wire::run),
    ("replay", replay::run),
    ("link", link::run),
    ("session", session::run),
    ("lines", lines::run),
    ("playout", playout::run),
];
