//! The step `packages`: what others install, as they would get it, and nothing uploaded.
//!
//! Nine crates as `cargo publish` packs them, each with what it includes inside, and the Python module's sources, unpacked in a folder of
//! their own and compiled there: a file that lies outside of its package is found by that. `cargo publish --dry-run` compiles each crate from what is
//! packed as well, which takes minutes; the tests leave it out.

use std::fs;
use std::path::{Path, PathBuf};

use crate::run::{Failure, cargo, command, run};
use crate::{board::target, platforms, python, run};

/// What the simulator and the analyser need of this repository, and they; and the laws of other papers.
pub(crate) const CRATES: [&str; 9] = [
    "cohold-core",
    "cohold-laws",
    "cohold-protocol",
    "cohold-io",
    "cohold-columns",
    "cohold-plot",
    "cohold-report",
    "cohold-sim",
    "cohold-analysis",
];

/// Packs and checks everything.
pub(crate) fn check() -> Result<(), Failure> {
    CRATES.iter().try_for_each(is_no_strangers)?;
    // What is not committed is packed too: it is what the tests look at.
    run(cargo(&["publish", "--dry-run", "--locked", "--allow-dirty", "--no-verify"]).args(named()))?;
    sources()
}

/// Asks crates.io for a name: it is free, or what it has carries this project's keyword.
fn is_no_strangers(name: &&'static str) -> Result<(), Failure> {
    // Elsewhere than in this workspace, whose own crate cargo would find.
    let mut ask = command("cargo", &["info", "--registry", "crates-io", name]);
    let told = ask.current_dir(std::env::temp_dir()).output().map_err(|cause| Failure::new(cause.to_string()))?;
    let [said, why] = [&told.stdout, &told.stderr].map(|text| String::from_utf8_lossy(text));
    if said.contains("#cohold") || why.contains("could not find") {
        return Ok(());
    }
    Err(Failure::new(format!("{name} is a stranger's on crates.io, or the index does not answer: {said}{why}")))
}

/// The crates as cargo is told of them.
pub(crate) fn named() -> impl Iterator<Item = &'static str> {
    CRATES.into_iter().flat_map(|name| ["--package", name])
}

/// Compiles the Python module from its own source distribution, in a folder where nothing else is.
fn sources() -> Result<(), Failure> {
    let place = target().join("sdist");
    let folder = unpacked(&sdist(run::root(), &place)?, &place)?;
    // Beside what was checked for another platform: of others' packages it is the same.
    let Some(mut check) = platforms::without_c(cargo(&[]))? else { return Ok(()) };
    check
        .args(["check", "--target", platforms::LINTED, "--manifest-path"])
        .arg(folder.join("host-sim/python/Cargo.toml"));
    run::compile(check.env("CARGO_TARGET_DIR", target()))
}

/// Packs the Python module of this checkout into this folder, emptied first.
pub(crate) fn sdist(source: &Path, place: &Path) -> Result<PathBuf, Failure> {
    let failed = |cause| Failure::new(format!("cannot make {}: {cause}", place.display()));
    if place.exists() {
        fs::remove_dir_all(place).map_err(failed)?;
    }
    let python = python::own_environment()?;
    let mut maturin = command(&python.to_string_lossy(), &["-m", "maturin", "sdist", "--out"]);
    run(maturin.arg(place).current_dir(source))?;
    let mut files = fs::read_dir(place).map_err(failed)?.flatten();
    let none = || Failure::new("maturin packed no sources");
    Ok(files.next().ok_or_else(none)?.path())
}

/// Unpacks them beside, and says where.
fn unpacked(packed: &Path, place: &Path) -> Result<PathBuf, Failure> {
    // As new as they are here: with the times that they were packed with, cargo takes what an older archive left for them.
    run(command("tar", &["-m", "--extract", "--gzip", "--file"]).arg(packed).arg("--directory").arg(place))?;
    let name = packed.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let folder = place.join(name.trim_end_matches(".tar.gz"));
    run::read(&folder.join("PKG-INFO")).map(|_| folder)
}
