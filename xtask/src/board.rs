//! `cargo xtask board`: the release image on two virtual boards, from the command line.
//!
//! Builds the image and the bench (tests/board, a workspace of its own), then hands the arguments on to the bench. Where
//! things are built: the image as cargo would, the bench in `tests/board/target`, or in `board/` below `CARGO_TARGET_DIR`.

use std::env;
use std::path::PathBuf;
use std::process::{Command, ExitCode};

use crate::run::{self, Failure, cargo, run, step};
use crate::setup::{self, Ready, THUMB_TARGET};

/// Builds and runs; `arguments` are the bench's, and so is exit status 2 where they are wrong.
pub(crate) fn board(arguments: &[&str]) -> Result<ExitCode, Failure> {
    let ready = step("set-up", setup::setup)?;
    let image = step("image", || image(&ready))?;
    let mut bench = bench(&["run", "--bin", "board"], &image);
    bench.arg("--").args(arguments);
    eprintln!("    {}", run::spelled(&bench));
    let status = bench.status().map_err(|cause| Failure::new(format!("cannot run cargo: {cause}")))?;
    match status.code() {
        Some(0) => Ok(ExitCode::SUCCESS),
        Some(2) => Ok(ExitCode::from(2)),
        _ => Err(Failure::new("the virtual boards did not run the scene (see above)")),
    }
}

/// Builds the release image and says where it is.
pub(crate) fn image(ready: &Ready) -> Result<PathBuf, Failure> {
    let mut build = cargo(&[
        "build",
        "--locked",
        "--release",
        "--package",
        "firmware",
        "--bin",
        "firmware",
        "--target",
        THUMB_TARGET,
    ]);
    if ready.fallback {
        build.arg("--ignore-rust-version");
    }
    run(build.env("RUSTUP_TOOLCHAIN", &ready.thumb_toolchain))?;
    Ok(target().join(THUMB_TARGET).join("release/firmware"))
}

/// Cargo on the bench, with the image that it is to run.
pub(crate) fn bench(arguments: &[&str], image: &std::path::Path) -> Command {
    let mut bench = cargo(arguments);
    // The emulator asks for a newer compiler than it needs (notes/virtual-board.md).
    bench.args(["--release", "--locked", "--ignore-rust-version", "--manifest-path", "tests/board/Cargo.toml"]);
    bench.env("HAPTIC_FIRMWARE", image);
    if let Some(shared) = env::var_os("CARGO_TARGET_DIR") {
        bench.env("CARGO_TARGET_DIR", run::root().join(shared).join("board"));
    }
    bench
}

/// Where cargo builds the workspace.
fn target() -> PathBuf {
    env::var_os("CARGO_TARGET_DIR").map_or_else(|| run::root().join("target"), |folder| run::root().join(folder))
}
