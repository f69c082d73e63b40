//! The part of `cargo xtask python` that is about LeRobot: both packages of host-sim/python/lerobot as they are installed, and its own loops with
//! them. It needs a newer Python than all else here does, and has an environment of its own below target/.

use std::path::{Path, PathBuf};

use crate::python::{environment, pip};
use crate::run::{self, Failure, command, run};

/// Where the packages are, their tests, and the versions of what they need.
const FOLDER: &str = "host-sim/python/lerobot";

/// LeRobot's own lowest, and the highest for which what it needs is there in these versions.
const FITTING: [&str; 2] = ["3.12", "3.13"];

/// Names under which a Python that fits may be found: on the path, and where pyenv keeps them.
fn candidates() -> Vec<String> {
    let mut names: Vec<String> = ["python3", "python3.12", "python3.13"].iter().map(|&name| name.into()).collect();
    let home = std::env::var_os("HOME").map(|home| Path::new(&home).join(".pyenv"));
    let root = std::env::var_os("PYENV_ROOT").map(PathBuf::from).or(home);
    let versions = root.and_then(|root| root.join("versions").read_dir().ok());
    let mut kept: Vec<PathBuf> = versions.into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    kept.sort();
    names.extend(kept.iter().map(|version| version.join("bin/python3").to_string_lossy().into_owned()));
    names
}

/// The first of them that runs and fits.
fn interpreter() -> Option<String> {
    let asks = format!("import sys; sys.exit('%d.%d' % sys.version_info[:2] not in {FITTING:?})");
    let fits = |name: &String| command(name, &["-c", &asks]).output().is_ok_and(|said| said.status.success());
    candidates().into_iter().find(fits)
}

/// Installs this wheel and both packages, and runs their tests, which compare with this cohold.
pub(crate) fn check(wheel: &Path, cohold: &Path) -> Result<(), Failure> {
    let Some(interpreter) = interpreter() else {
        return run::due_in_ci(format!(
            "LeRobot's packages need Python {}, and there is none: install Debian 13's python3.13-venv, or one by pyenv",
            FITTING.join(" or ")
        ));
    };
    // As they stand there: LeRobot asks for PyTorch, for which the tests have a stand-in.
    let requirements = format!("{FOLDER}/requirements.txt");
    let (folder, options) = (run::root().join("target/lerobot"), ["--no-deps", "--no-compile"]);
    let python = environment(&interpreter, &folder, &requirements, &options)?;
    let packages = ["lerobot_robot_haptic", "lerobot_teleoperator_haptic"].map(|name| format!("{FOLDER}/{name}"));
    let own = ["--force-reinstall", "--no-deps", "--no-index", "--no-build-isolation"];
    run(pip(&python).args(own).arg(wheel).args(&packages))?;
    let mut tests = command(&python.to_string_lossy(), &["-m", "pytest", "--quiet", "-p", "no:cacheprovider"]);
    run(tests.env("COHOLD", cohold).arg(format!("{FOLDER}/tests")))
}
