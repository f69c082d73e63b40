//! `cargo xtask board`: the release image on two virtual boards, from the command line.
//!
//! Looks at the command line, builds the image and the bench (tests/board), then hands the arguments on.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use crate::options::Options;
use crate::run::{self, Failure, cargo, step};
use crate::setup::{self, Ready, THUMB_TARGET};

/// What cargo is given for each image: for one shared axis, for three, for the second board, for a moteus, for encoders on SPI, by USB.
pub(crate) const IMAGES: [&[&str]; 6] = [
    &[],
    &["--features", "three-axes"],
    &["--no-default-features", "--features", "nucleo-h753zi"],
    &["--features", "moteus"],
    &["--features", "spi-encoders"],
    &["--features", "usb"],
];
/// What those beside the first are called there.
pub(crate) const BESIDES: [&str; 5] =
    ["firmware-three-axes", "firmware-nucleo-h753zi", "firmware-moteus", "firmware-spi-encoders", "firmware-usb"];
/// An image for virtual boards alone: what it is given, and what it is called there.
const MEASURED: (&[&str], &str) = (&["--features", "fixed-point"], "firmware-fixed-point");
/// Longest run, s.
const MOST_SECONDS: f64 = 3600.0;

/// What is wrong with the values is one line, before anything is built; the scene and its overrides the bench looks at.
fn check(given: &Options<'_>) -> Result<(), Failure> {
    given.pairs().find_map(|(option, value)| wrong(option, value)).map_or(Ok(()), |wrong| Err(Failure::usage(wrong)))
}

/// What is wrong with the value of an option.
fn wrong(option: &str, value: &str) -> Option<String> {
    let allowed = match option {
        "--seconds" if value.parse().is_ok_and(|seconds| (1.0..=MOST_SECONDS).contains(&seconds)) => return None,
        "--seconds" => format!("it must be a number from 1 to {MOST_SECONDS}"),
        "--set" if value.split_once('=').is_some_and(|(key, _)| key.contains('.')) => return None,
        "--set" => "it must be TABLE.KEY=VALUE".to_owned(),
        "--scene" if Path::new(value).is_file() || built_in().any(|name| name == value) => return None,
        "--scene" => format!("it must be a file or one of {}", built_in().collect::<Vec<_>>().join(", ")),
        _ => return None,
    };
    Some(format!("{option} \"{value}\" is not allowed: {allowed}"))
}

/// The scenes that cohold has built in, by name: those of the folder.
fn built_in() -> impl Iterator<Item = String> {
    let files = fs::read_dir(run::root().join("scenes")).into_iter().flatten().flatten();
    let mut names: Vec<String> =
        files.filter_map(|file| file.file_name().to_str()?.strip_suffix(".toml").map(str::to_owned)).collect();
    names.sort();
    names.into_iter()
}

/// Builds and runs; exit status 2 where the bench refuses the scene.
pub(crate) fn board(given: &Options<'_>) -> Result<(), Failure> {
    check(given)?;
    let ready = step("set-up", setup::setup)?;
    let image = step("image", || image(&ready))?;
    let mut bench = bench(&["run", "--bin", "board"], &image);
    // Files are named as seen from where the command was given.
    let here = env::current_dir().map_err(|cause| Failure::new(format!("no working directory: {cause}")))?;
    bench.arg("--").args(given.words()).current_dir(here);
    eprintln!("    {}", run::spelled(&bench));
    let status = bench.status().map_err(|cause| Failure::new(format!("cannot run cargo: {cause}")))?;
    match status.code() {
        Some(0) => Ok(()),
        // It has said why.
        Some(2) => Err(Failure::usage("")),
        _ => Err(Failure::new("the virtual boards did not run the scene (see above)")),
    }
}

/// Builds the release image and says where it is.
pub(crate) fn image(ready: &Ready) -> Result<PathBuf, Failure> {
    built(&mut build(ready, "build", IMAGES[0]))
}

/// Builds the other images, which are put beside the first, and that one again: all come out under one name.
pub(crate) fn images(ready: &Ready) -> Result<PathBuf, Failure> {
    for (features, name) in IMAGES[1..].iter().copied().zip(BESIDES).chain([MEASURED]) {
        let other = built(&mut build(ready, "build", features))?;
        let place = other.with_file_name(name);
        fs::copy(&other, &place).map_err(|cause| Failure::new(format!("cannot write {}: {cause}", place.display())))?;
    }
    image(ready)
}

/// Cargo on the image with these features: `build`, or `rustc`.
pub(crate) fn build(ready: &Ready, what: &str, features: &[&str]) -> Command {
    let mut build = ready.cargo(&[what, "--locked", "--profile", "firmware", "--package", "firmware"]);
    build.args(["--bin", "firmware", "--target", THUMB_TARGET]).args(features);
    build
}

fn built(build: &mut Command) -> Result<PathBuf, Failure> {
    run::compile(build)?;
    Ok(target().join(THUMB_TARGET).join("firmware/firmware"))
}

/// Cargo on the bench, with the image that it is to run.
pub(crate) fn bench(arguments: &[&str], image: &Path) -> Command {
    let mut bench = run::linted(cargo(arguments));
    // The emulator asks for a newer compiler than it needs.
    bench.args(["--locked", "--ignore-rust-version", "--manifest-path"]);
    bench.arg(run::root().join("tests/board/Cargo.toml"));
    bench.env("COHOLD_FIRMWARE", image);
    bench
}

/// Where cargo builds the workspace.
pub(crate) fn target() -> PathBuf {
    env::var_os("CARGO_TARGET_DIR").map_or_else(|| run::root().join("target"), |folder| run::root().join(folder))
}

#[cfg(test)]
#[path = "../tests/inside/board.rs"]
mod tests;
