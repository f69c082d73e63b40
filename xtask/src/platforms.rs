//! The step `platforms`: the compiler's check of everything for a PC, the Python module included, for systems that no test here
//! runs on, and the lints of what no test compiles. Clippy looks at one of these systems: of the others it would say the same of
//! nearly every line.
//!
//! Nothing is linked or run. `ring` compiles C in its build script even so: zig is the C compiler for every target, and comes with
//! cargo-zigbuild from Python's registry, as for the wheel. PyO3 needs no Python of the target, because the module uses the stable ABI.

use std::process::Command;

use crate::python;
use crate::run::{self, Failure, cargo, command, compile, everything};

/// What is only checked.
const CHECKED: [&str; 2] = ["x86_64-pc-windows-gnu", "aarch64-apple-darwin"];
/// What is linted and documented as well: benches and examples that no test compiles.
pub(crate) const LINTED: &str = "aarch64-unknown-linux-gnu";
/// Packages for another processor, or for the emulator of one.
const NOT_FOR_PCS: [&str; 3] = ["board-bench", "firmware", "haptic-rig"];

/// What cargo is called with: each call has its platforms' build scripts and macros compiled once.
pub(crate) fn calls() -> [Command; 3] {
    let on = |what: &str, targets: &[&str]| {
        let mut call = everything(what);
        call.args(NOT_FOR_PCS.iter().flat_map(|package| ["--exclude", package]));
        call.args(targets.iter().flat_map(|target| ["--target", target]));
        call
    };
    let mut lints = on("check", &[LINTED]);
    lints.args(["--lib", "--bins", "--benches", "--examples"]);
    // Of what a fresh clone builds: all else has no public documentation.
    let documentation = cargo(&["doc", "--locked", "--no-deps", "--lib", "--target", LINTED]);
    [on("check", &CHECKED), lints, documentation]
}

/// cargo-zigbuild with every target's core; if a platform cannot be prepared it says so, and fails where CI is set.
pub(crate) fn zig() -> Result<Option<Command>, Failure> {
    let targets = CHECKED.into_iter().chain([LINTED]);
    match run::run(command("rustup", &["target", "add"]).args(targets)).and_then(|()| python::by_zig()) {
        Ok(zig) => Ok(Some(zig)),
        Err(failure) => run::due_in_ci(format!(
            "{failure}, so nothing is compiled for other platforms; the first time needs static.rust-lang.org and Python's registry"
        ))
        .map(|()| None),
    }
}

/// Checks every platform, lints and documentation.
pub(crate) fn check() -> Result<(), Failure> {
    for (nth, call) in calls().into_iter().enumerate() {
        let Some(zig) = zig()? else { return Ok(()) };
        let (mut zig, flags) = if nth == 0 { (zig, "RUSTFLAGS") } else { (run::linted(zig), "RUSTDOCFLAGS") };
        compile(zig.args(call.get_args()).env(flags, "-D warnings"))?;
    }
    Ok(())
}
