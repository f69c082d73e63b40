//! `cargo xtask wheel` and `cargo xtask python`: cohold as a Python module, built with maturin and tested as it is installed.
//!
//! What both need of Python comes from the registry, in the versions of host-sim/python/requirements.txt, into a virtual environment
//! below target/.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use crate::lerobot;
use crate::run::{self, Failure, cargo, command, run};

/// A linker with C libraries for other systems than this one, and cargo with it, as Python's registry has them.
const ZIG: [&str; 2] = ["ziglang==0.17.1", "cargo-zigbuild==0.24.0"];
/// Where it is looked for.
const ZIG_IN: &str = "CARGO_ZIGBUILD_PYTHON_PATH";

/// This Python in a virtual environment of this folder, with what the requirements name, installed with these flags of pip's; made anew when
/// they have changed.
pub(crate) fn environment(
    interpreter: &str,
    folder: &Path,
    requirements: &str,
    flags: &[&str],
) -> Result<PathBuf, Failure> {
    let (wanted, there) = (run::root().join(requirements), folder.join("requirements.txt"));
    let python = folder.join("python/bin/python");
    let text = run::read(&wanted)?;
    if fs::read_to_string(&there).is_ok_and(|there| there == text) {
        return Ok(python);
    }
    let place = folder.join("python");
    run(&mut command(interpreter, &["-m", "venv", "--clear", &place.to_string_lossy()]))?;
    run(pip(&python).args(flags).arg("--requirement").arg(&wanted))?;
    fs::write(&there, text).map_err(|cause| Failure::new(format!("cannot write {}: {cause}", there.display())))?;
    Ok(python)
}

pub(crate) fn pip(python: &Path) -> Command {
    command(&python.to_string_lossy(), &["-m", "pip", "install", "--quiet", "--disable-pip-version-check"])
}

/// What the wheel is built and tested with.
pub(crate) fn own_environment() -> Result<PathBuf, Failure> {
    environment("python3", &run::root().join("target/python"), "host-sim/python/requirements.txt", &[])
}

/// Builds the wheel of these sources with a profile of cargo's into this folder, and says where it is. One to give away is linked by zig, which has
/// what older systems have: a Linux from 2014 on (glibc 2.17) takes it, and maturin looks at every name that it wants of the system.
pub(crate) fn wheel(source: &Path, folder: &Path, profile: &str) -> Result<PathBuf, Failure> {
    let python = own_environment()?;
    let built = folder.join(".new");
    let _ = fs::remove_dir_all(&built);
    let mut maturin = command(&python.to_string_lossy(), &["-m", "maturin", "build", "--profile", profile, "--locked"]);
    if profile == "release" && cfg!(target_os = "linux") {
        run(pip(&python).args(ZIG))?;
        maturin.args(["--zig", "--compatibility", "manylinux_2_17"]).env(ZIG_IN, &python);
    }
    if profile == "dev" {
        maturin = run::linted(maturin);
    }
    run::compile(maturin.arg("--interpreter").arg(&python).arg("--out").arg(&built).current_dir(source))?;
    let failed = |cause| Failure::new(format!("cannot put the wheel into {}: {cause}", folder.display()));
    let mut files = fs::read_dir(&built).map_err(failed)?.flatten();
    let new = files.next().ok_or_else(|| Failure::new("maturin made no wheel"))?.path();
    let name = new.file_name().unwrap_or_default().to_string_lossy();
    is_for_others(&name)?;
    let wheel = folder.join(&*name);
    fs::rename(&new, &wheel).and_then(|()| fs::remove_dir(&built)).map_err(failed)?;
    Ok(wheel)
}

/// Cargo's build for Linux with glibc 2.17 and later, linked by zig, and where it leaves a release; elsewhere that of this machine's system.
pub(crate) fn build_by_zig() -> Result<(Command, String), Failure> {
    if !cfg!(target_os = "linux") {
        return Ok((cargo(&["build"]), "release".to_owned()));
    }
    let target = format!("{}-unknown-linux-gnu", env::consts::ARCH);
    let python = own_environment()?;
    run(pip(&python).args(ZIG))?;
    let mut build = command(&python.with_file_name("cargo-zigbuild").to_string_lossy(), &[]);
    build.env(ZIG_IN, &python).args(["zigbuild", "--target", &format!("{target}.2.17")]);
    Ok((build, format!("{target}/release")))
}

/// A wheel that says `linux` is of this machine alone, and no registry takes it: maturin says `manylinux` and the glibc that it needs at least where
/// nothing but what every Linux has is linked.
fn is_for_others(name: &str) -> Result<(), Failure> {
    let system = name.trim_end_matches(".whl").rsplit('-').next().unwrap_or_default();
    if system.starts_with("linux") {
        return Err(Failure::new(format!("{name} is for this machine alone: it links what not every Linux has")));
    }
    Ok(())
}

/// Builds the wheel, installs it, and has host-sim/python/tests compare what it gives with the command line's word.
pub(crate) fn python() -> Result<(), Failure> {
    // Of the build that the tests have made, as the command line is below: any build computes the same bits.
    let wheel = wheel(run::root(), &run::root().join("target/python"), "dev")?;
    let python = own_environment()?;
    run(pip(&python).args(["--force-reinstall", "--no-deps", "--no-index"]).arg(&wheel))?;
    let cohold = run::cohold(false)?;
    let mut tests = command(&python.to_string_lossy(), &["-m", "pytest", "--quiet", "-p", "no:cacheprovider"]);
    run(tests.arg("host-sim/python/tests").env("COHOLD", &cohold))?;
    lerobot::check(&wheel, &cohold)
}

#[cfg(test)]
#[path = "../tests/inside/python.rs"]
mod tests;
