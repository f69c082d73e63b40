//! `cargo xtask test`: everything that must pass before a change is taken, cheapest first. Stops at the first failure.
//!
//! Steps that name no package run on the workspace's default members: everything that builds on a PC.
//! It takes the machine as it is: what is missing is installed. `Cargo.lock` is part of the project: a step that would have
//! to change it fails.

use std::time::Instant;

use crate::run::{self, Failure, cargo, run, step};
use crate::setup::{self, Ready, THUMB_TARGET};
use crate::{board, count, no_panic, page, python, qemu, recordings};

/// Runs every step.
pub(crate) fn test() -> Result<(), Failure> {
    let start = Instant::now();
    let ready = step("set-up", setup::setup)?;
    step("format", format)?;
    step("lints", lints)?;
    step("rooms", || crate::rooms::rooms(run::root()))?;
    step("page", || page::browser().and_then(|()| page::page(false)))?;
    step("rooms of the microcontroller", || {
        // As the image is: what they need is not built twice.
        let mut build = ready.cargo(&["build", "--locked", "--profile", "firmware", "--target", THUMB_TARGET]);
        run(build.args(["--package", "haptic-core", "--package", "haptic-protocol"]))
    })?;
    step("documentation", || run(cargo(&["doc", "--locked", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings")))?;
    step("tests, debug", || run(&mut cargo(&["test", "--locked"])))?;
    step("recordings", recordings::recordings)?;
    step("parts of the image", || {
        // What of it needs no chip.
        run(&mut cargo(&["test", "--locked", "--package", "firmware", "--test", "parts"]))
    })?;
    step("golden traces, release", || {
        // The same bits in every build.
        run(&mut cargo(&["test", "--locked", "--release", "--package", "haptic-sim", "--test", "golden"]))
    })?;
    step("no panic in the tick", || no_panic::no_panic(&ready))?;
    step("README", || crate::readme::readme(true, None))?;
    step("Python", python::python)?;
    step("instructions of one tick", || match count::obstacle() {
        None => count::ticks(false),
        Some(obstacle) => {
            eprintln!("    NOT CHECKED: {obstacle}");
            Ok(())
        }
    })?;
    step("exchange cells under every interleaving", exchange)?;
    step("second opinion", || second_opinion(&ready))?;
    step("lints of image and bench", || lints_of_image(&ready))?;
    virtual_board(&ready)?;
    passed(start);
    Ok(())
}

/// Runs what tells soonest whether a small change is good: format, lints, who leans on whom, unit tests, golden traces.
pub(crate) fn quick() -> Result<(), Failure> {
    let start = Instant::now();
    step("format", format)?;
    step("lints", lints)?;
    step("rooms", || crate::rooms::rooms(run::root()))?;
    step("unit tests", || run(&mut cargo(&["test", "--locked", "--lib", "--bins"])))?;
    step("golden traces", || run(&mut cargo(&["test", "--locked", "--package", "haptic-sim", "--test", "golden"])))?;
    passed(start);
    Ok(())
}

fn passed(start: Instant) {
    let spent = run::processor_s().map_or(String::new(), |spent| format!(", {spent:.0} s of processor time"));
    eprintln!("every step passed in {:.0} s{spent}", start.elapsed().as_secs_f64());
}

fn format() -> Result<(), Failure> {
    run(&mut cargo(&["fmt", "--all", "--check"])).map_err(|failure| advice(&failure, "`cargo fmt --all` mends it"))
}

fn lints() -> Result<(), Failure> {
    run(&mut cargo(&["clippy", "--locked", "--all-targets", "--", "-D", "warnings"]))
}

/// The memory that interrupt and tasks share, under loom, which runs every order that its operations can have.
fn exchange() -> Result<(), Failure> {
    let mut loom = cargo(&["test", "--locked", "--release", "--package", "firmware", "--lib", "exchange"]);
    run(loom.env("RUSTFLAGS", "--cfg loom").env("CARGO_TARGET_DIR", run::root().join("target/loom")))
}

/// haptic-core on another model of the processor; without one it says so, and fails where CI is set.
pub(crate) fn second_opinion(ready: &Ready) -> Result<(), Failure> {
    match qemu::obstacle() {
        None => qemu::qemu(ready),
        Some(obstacle) if std::env::var_os("CI").is_some() => Err(Failure::new(obstacle)),
        Some(obstacle) => {
            eprintln!("    NOT CHECKED: {obstacle}");
            Ok(())
        }
    }
}

/// What the workspace's own lints do not reach: both images, and the bench, which is a workspace of its own.
fn lints_of_image(ready: &Ready) -> Result<(), Failure> {
    if ready.fallback {
        // Debian's toolchain has no clippy of its own.
        eprintln!("    NOT CHECKED: the images, their toolchain is Debian's");
    } else {
        for features in [&[][..], &["--features", "three-axes"]] {
            let mut image =
                cargo(&["clippy", "--locked", "--profile", "firmware", "--package", "firmware", "--bin", "firmware"]);
            image.args(["--target", THUMB_TARGET]).args(features);
            run(image.args(["--", "-D", "warnings"]).env("RUSTUP_TOOLCHAIN", &ready.thumb_toolchain))?;
        }
    }
    run(board::bench(&["clippy"], &board::image(ready)?).args(["--all-targets", "--", "-D", "warnings"]))
}

/// Only the release image on virtual boards.
pub(crate) fn board_test() -> Result<(), Failure> {
    let ready = step("set-up", setup::setup)?;
    virtual_board(&ready)
}

/// The release image on virtual boards: last, because its emulator takes minutes to build.
fn virtual_board(ready: &Ready) -> Result<(), Failure> {
    step("virtual board", || {
        let image = board::images(ready)?;
        run(&mut board::bench(&["test"], &image)).map_err(|failure| {
            advice(
                &failure,
                "if the lock is what failed, `cargo metadata --manifest-path tests/board/Cargo.toml` renews it",
            )
        })
    })
}

fn advice(failure: &Failure, advice: &str) -> Failure {
    Failure::new(format!("{failure}; {advice}"))
}
