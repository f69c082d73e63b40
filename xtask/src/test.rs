//! `cargo xtask test`: everything that must pass before a change is taken, cheapest first. Stops at the first failure.
//!
//! Most steps run on everything that builds on a PC, whatever they then choose of it: so nothing is built twice.
//! It takes the machine as it is: what is missing is installed. `Cargo.lock` is part of the project: a step that would have
//! to change it fails.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use crate::run::{self, Failure, cargo, everything, run, step};
use crate::setup::{self, Ready, THUMB_TARGET};
use crate::{board, count, homes, kept, no_panic, packages, page, python, qemu, recordings, rig, sums};

/// Runs every step.
pub(crate) fn test() -> Result<(), Failure> {
    let start = Instant::now();
    let ready = step("set-up", setup::setup)?;
    step("format", format)?;
    step("lints", || run(&mut lints()))?;
    step("rooms", crate::rooms::rooms)?;
    step("licences", crate::licences::licences)?;
    step("sums", || sums::sums(&calls(&ready), false))?;
    step("page", || page::browser().and_then(|()| page::page(false)))?;
    step("rooms of the microcontroller", || run(&mut rooms_on_chip(&ready)))?;
    step("documentation", || run(documentation().env("RUSTDOCFLAGS", "-D warnings")))?;
    // Parts of the image that need no chip and the programs of examples/ included; the virtual boards come last.
    step("tests, debug", || run(everything("test").args(["--exclude", "board-bench"])))?;
    step("recordings", recordings::recordings)?;
    step("golden traces, release", || run(&mut golden()))?;
    step("no panic in the tick", || no_panic::no_panic(&ready))?;
    // As a newcomer's first command builds it: the pages need it next.
    let before = run::processor_s();
    step("first picture", || run(&mut cargo(&["build", "--locked", "--release"])))?;
    sums::took("the first build, s", run::processor_s().zip(before).map(|(now, then)| now - then))?;
    step("README", || crate::readme::readme(true, None))?;
    step("Python", python::python)?;
    step("packages", packages::check)?;
    step("instructions of one tick", || match count::obstacle() {
        None => count::ticks(false),
        Some(obstacle) => {
            run::not_checked(&obstacle);
            Ok(())
        }
    })?;
    step("exchange cells under every interleaving", || run(&mut interleavings()))?;
    step("second opinion", || second_opinion(&ready))?;
    step("two homes behind routers", || match homes::obstacle() {
        None => homes::homes(),
        Some(obstacle) => {
            run::not_checked(&obstacle);
            Ok(())
        }
    })?;
    step("lints of the images", || lints_of_images(&ready))?;
    step("virtual board", || {
        let image = board::images(&ready)?;
        match kept::passed(&image) {
            Some(when) => {
                eprintln!(
                    "    virtual boards: image and bench are those that passed on {when}; `cargo xtask board-test` runs them"
                );
                Ok(())
            }
            None => virtual_board(&ready, &image),
        }
    })?;
    passed(start);
    sums::took("cargo xtask test, s", run::processor_s())
}

/// What `cargo xtask test` has cargo compile, without the few crates of tests/qemu.
pub(crate) fn calls(ready: &Ready) -> Vec<Command> {
    let mut calls = vec![lints(), documentation(), everything("test"), golden(), interleavings()];
    calls.extend([count::bench(), cargo(&["build", "--locked", "--package", "haptic-python"])]);
    calls.push(rooms_on_chip(ready));
    for features in board::IMAGES {
        calls.push(board::build(ready, features));
        calls.push(lints_of_image(ready, features));
        calls.extend(no_panic::proofs(ready, features));
    }
    calls.extend(["build", "clippy"].map(|what| rig::build(ready, what)));
    calls
}

/// Runs what tells soonest whether a small change is good: format, lints, who leans on whom, unit tests, golden traces.
pub(crate) fn quick() -> Result<(), Failure> {
    let start = Instant::now();
    step("format", format)?;
    step("lints", || run(&mut lints()))?;
    step("rooms", crate::rooms::rooms)?;
    step("unit tests", || run(everything("test").args(["--lib", "--bins"])))?;
    step("golden traces", || run(everything("test").args(["--test", "golden"])))?;
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

/// Clippy on everything.
pub(crate) fn lints() -> Command {
    let mut lints = everything("clippy");
    lints.args(["--all-targets", "--", "-D", "warnings"]);
    lints
}

/// Core, protocol and the roles of the environments for the microcontroller. As the image is: what they need is not built twice.
pub(crate) fn rooms_on_chip(ready: &Ready) -> Command {
    let mut build = ready.cargo(&["build", "--locked", "--profile", "firmware", "--target", THUMB_TARGET]);
    build.args(["--package", "haptic-core", "--package", "haptic-protocol"]);
    build.args(["--package", "haptic-environments", "--no-default-features"]);
    build
}

/// Documentation of the libraries.
pub(crate) fn documentation() -> Command {
    cargo(&["doc", "--locked", "--no-deps"])
}

/// The golden traces as a release computes them: the same bits in every build.
pub(crate) fn golden() -> Command {
    let mut golden = everything("test");
    golden.args(run::AS_RELEASED).args(["--test", "golden"]);
    golden
}

/// The memory that interrupt and tasks share, under loom, which runs every order that its operations can have.
pub(crate) fn interleavings() -> Command {
    let mut loom = everything("test");
    loom.args(["--features", "firmware/loom", "--test", "interleavings"]);
    loom
}

/// haptic-core on another model of the processor; without one it says so, and fails where CI is set.
pub(crate) fn second_opinion(ready: &Ready) -> Result<(), Failure> {
    match qemu::obstacle() {
        None => qemu::qemu(ready),
        Some(obstacle) => run::due_in_ci(obstacle),
    }
}

/// What the lints of what builds on a PC do not reach: the images.
fn lints_of_images(ready: &Ready) -> Result<(), Failure> {
    if ready.fallback {
        // Debian's toolchain has no clippy of its own.
        run::not_checked("the images, their toolchain is Debian's");
        return Ok(());
    }
    board::IMAGES.into_iter().try_for_each(|features| run(&mut lints_of_image(ready, features)))?;
    run(rig::build(ready, "clippy").args(["--", "-D", "warnings"]))
}

/// Clippy on the image with these features.
pub(crate) fn lints_of_image(ready: &Ready, features: &[&str]) -> Command {
    let mut lints = ready.cargo(&["clippy", "--locked", "--profile", "firmware", "--package", "firmware"]);
    lints.args(["--bin", "firmware", "--target", THUMB_TARGET]).args(features).args(["--", "-D", "warnings"]);
    lints
}

/// Only the release image on virtual boards.
pub(crate) fn board_test() -> Result<(), Failure> {
    let ready = step("set-up", setup::setup)?;
    step("virtual board", || virtual_board(&ready, &board::images(&ready)?))
}

/// The release image on virtual boards, beside the rig's first: last, because their emulator takes minutes to build.
fn virtual_board(ready: &Ready, image: &Path) -> Result<(), Failure> {
    step("rig, virtual", || rig::on_virtual_boards(ready, image, &[]))?;
    run(&mut board::bench(&["test"], image))?;
    kept::keep(image)
}

fn advice(failure: &Failure, advice: &str) -> Failure {
    Failure::new(format!("{failure}; {advice}"))
}
