//! The step `platforms`: the compiler's check of everything for a PC, the Python module included, for systems that no test here
//! runs on, and the lints of what no test compiles. Clippy looks at one of these systems: of the others it would say the same of
//! nearly every line.
//!
//! Nothing is linked or run, so no C is compiled either: where a build script asks for it, `true` stands in for compiler and archiver.
//! PyO3 needs no Python of the target, because the module uses the stable ABI.

use std::process::Command;

use crate::run::{self, Failure, cargo, command, compile, everything};

/// What is only checked.
const CHECKED: [&str; 2] = ["x86_64-pc-windows-gnu", "aarch64-apple-darwin"];
/// What is linted and documented as well: benches and examples that no test compiles.
pub(crate) const LINTED: &str = "aarch64-unknown-linux-gnu";
/// Packages for another processor, or for the emulator of one.
const NOT_FOR_PCS: [&str; 3] = ["board-bench", "firmware", "cohold-rig"];

/// What cargo is called with: each call has its platforms' build scripts and macros compiled once.
pub(crate) fn calls() -> [Command; 3] {
    let on = |what: &str, targets: &[&str]| {
        let mut call = everything(what);
        call.args(NOT_FOR_PCS.iter().flat_map(|package| ["--exclude", package]));
        call.args(targets.iter().flat_map(|target| ["--target", target]));
        call
    };
    let mut lints = on("check", &[LINTED]);
    // Not `--benches`, which checks each library once more.
    lints.args(["--lib", "--bins", "--bench", "*", "--examples"]);
    // Of what a fresh clone builds: all else has no public documentation.
    let documentation = cargo(&["doc", "--locked", "--no-deps", "--lib", "--target", LINTED]);
    [on("check", &CHECKED), lints, documentation]
}

/// The call with every target's core, and without a C compiler; if a platform cannot be prepared it says so, and fails where CI is set.
pub(crate) fn without_c(mut call: Command) -> Result<Option<Command>, Failure> {
    call.env("TARGET_CC", "true").env("TARGET_AR", "true");
    let targets = CHECKED.into_iter().chain([LINTED]);
    match run::run(command("rustup", &["target", "add"]).args(targets)) {
        Ok(()) => Ok(Some(call)),
        Err(failure) => run::due_in_ci(format!(
            "{failure}, so nothing is compiled for other platforms; the first time needs static.rust-lang.org"
        ))
        .map(|()| None),
    }
}

/// Checks every platform, lints and documentation.
pub(crate) fn check() -> Result<(), Failure> {
    for (nth, call) in calls().into_iter().enumerate() {
        let Some(mut call) = without_c(call)? else { return Ok(()) };
        // What is only checked is not linted.
        match nth {
            0 => compile(call.env_remove("RUSTC_WORKSPACE_WRAPPER").env("RUSTFLAGS", "-D warnings"))?,
            _ => compile(run::linted(call).env("RUSTDOCFLAGS", "-D warnings"))?,
        }
    }
    Ok(())
}
