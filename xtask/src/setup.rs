//! The step `set-up`: installs what building and testing need and this machine lacks.
//!
//! rust-toolchain.toml asks for the components and the microcontroller's target, but rustup ignores it where
//! `RUSTUP_AUTO_INSTALL=0`. So each is looked for, cheaply and without the network, and installed only when missing:
//! when all is there, this takes a fraction of a second.
//!
//! Where `rustup target add` is refused, `thumb-toolchain.sh` makes a toolchain named `deb-thumb` from Debian's sources of
//! the standard library. Its compiler is Debian's, older than the project's, so it serves only as long as cohold-core and
//! what it depends on accept it; cargo says so when they do not.

use std::io::{self, BufRead, IsTerminal as _};
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::run::{self, Failure, cargo, command};
use crate::test::WAITED_FOR;

/// The microcontroller.
pub(crate) const THUMB_TARGET: &str = "thumbv7em-none-eabihf";
/// The toolchain that `thumb-toolchain.sh` makes.
const FALLBACK_TOOLCHAIN: &str = "deb-thumb";

/// What the set-up found or made.
pub(crate) struct Ready {
    /// The rustup toolchain that builds for the microcontroller.
    pub(crate) thumb_toolchain: String,
    /// It is not the project's own toolchain.
    pub(crate) fallback: bool,
}

impl Ready {
    /// Cargo with the toolchain for the microcontroller. Debian's compiler is older than the version the workspace
    /// promises; whether it will do, it says itself.
    pub(crate) fn cargo(&self, arguments: &[&str]) -> Command {
        let mut cargo = cargo(arguments);
        cargo.args(self.fallback.then_some("--ignore-rust-version"));
        cargo.env("RUSTUP_TOOLCHAIN", &self.thumb_toolchain);
        cargo
    }
}

/// Makes sure of everything; idempotent.
pub(crate) fn setup() -> Result<Ready, Failure> {
    for (component, probe) in [("rustfmt", "fmt"), ("clippy", "clippy")] {
        if !run::succeeds(&mut cargo(&[probe, "--version"])) {
            run::run(&mut command("rustup", &["component", "add", component])).map_err(|failure| {
                Failure::new(format!("{failure}: install {component} for the toolchain of rust-toolchain.toml by hand"))
            })?;
        }
    }
    thumb()
}

/// Why a program cannot be had, if so; installs its Debian package where that is all that is missing and nobody at a terminal is
/// against it. The program answers what follows its name, or `--version`.
pub(crate) fn program(asked: &str, package: &str) -> Option<String> {
    let (name, version) = asked.split_once(' ').unwrap_or((asked, "--version"));
    let present = || run::succeeds(&mut command(name, &[version]));
    if present() {
        return None;
    }
    let apt = |arguments: &[&str]| {
        let root = run::output(&mut command("id", &["-u"])).is_ok_and(|id| id.trim() == "0");
        let mut words = if root { vec![] } else { vec!["sudo", "-n"] };
        words.push("apt-get");
        words.extend(arguments);
        let mut apt = command(words[0], &words[1..]);
        apt.env("DEBIAN_FRONTEND", "noninteractive");
        apt
    };
    let missing = format!("{name} is missing; install {package} by hand");
    if std::env::var_os(WAITED_FOR).is_some() {
        return Some(missing);
    }
    let mut install = apt(&["install", "-qq", "--no-install-recommends", package]);
    let asks = std::env::var_os("CI").is_none() && io::stdin().is_terminal() && io::stderr().is_terminal();
    if asks {
        eprint!("    {name} is missing. Install Debian's package {package} with `{}`? [y/N] ", run::spelled(&install));
        if !is_yes(io::stdin().lock()) {
            return Some(missing);
        }
    }
    match run::run(&mut apt(&["update", "-qq"])).and_then(|()| run::run(&mut install)) {
        Ok(()) if present() => None,
        Ok(()) => Some(format!("{package} was installed but does not run; see `{name} {version}`")),
        Err(failure) => Some(format!("{name} is missing and {failure}; install {package} by hand")),
    }
}

/// Whether the next line agrees. An empty line, the end of the input and anything else do not.
fn is_yes(mut answers: impl BufRead) -> bool {
    let mut answer = String::new();
    answers.read_line(&mut answer).is_ok() && ["y", "yes"].contains(&answer.trim().to_lowercase().as_str())
}

/// The toolchain for the microcontroller: the project's own if it can be had.
fn thumb() -> Result<Ready, Failure> {
    let project = Ready { thumb_toolchain: project_toolchain()?, fallback: false };
    let fallback = || Ready { thumb_toolchain: FALLBACK_TOOLCHAIN.to_owned(), fallback: true };
    if sysroot(&project.thumb_toolchain).is_some_and(|sysroot| has_target(&sysroot)) {
        return Ok(project);
    }
    if sysroot(FALLBACK_TOOLCHAIN).is_some_and(|sysroot| has_target(&sysroot)) {
        return Ok(fallback());
    }
    let add =
        run::run(&mut command("rustup", &["target", "add", THUMB_TARGET, "--toolchain", &project.thumb_toolchain]));
    if add.is_ok() {
        return Ok(project);
    }
    eprintln!("    rustup could not add {THUMB_TARGET}: making a toolchain from Debian's sources");
    let mut script = command("xtask/thumb-toolchain.sh", &[]);
    match run::output(script.env("THUMB_TRY_RUSTUP", "0").env("THUMB_TARGET", THUMB_TARGET)) {
        Ok(name) if name.trim() == FALLBACK_TOOLCHAIN => Ok(fallback()),
        Ok(name) => Ok(Ready { thumb_toolchain: name.trim().to_owned(), ..project }),
        Err(failure) => Err(Failure::new(format!(
            "{failure}, after `rustup target add {THUMB_TARGET}` had failed too: give this machine access to \
             static.rust-lang.org, or install the target by hand"
        ))),
    }
}

/// The toolchain that rust-toolchain.toml names.
fn project_toolchain() -> Result<String, Failure> {
    let text = run::output(&mut command("rustup", &["show", "active-toolchain"]))
        .map_err(|failure| Failure::new(format!("{failure}; install rustup from https://rustup.rs")))?;
    text.split_whitespace().next().map(str::to_owned).ok_or_else(|| {
        Failure::new("`rustup show active-toolchain` named none: run `rustup toolchain install` in the workspace root")
    })
}

/// Where a toolchain keeps its libraries, if it is installed.
fn sysroot(toolchain: &str) -> Option<PathBuf> {
    let mut rustc: Command = command("rustup", &["run", toolchain, "rustc", "--print", "sysroot"]);
    let output = rustc.output().ok().filter(|output| output.status.success())?;
    Some(PathBuf::from(String::from_utf8_lossy(&output.stdout).trim()))
}

/// Whether the toolchain has `core` for the microcontroller.
fn has_target(sysroot: &Path) -> bool {
    let libraries = sysroot.join("lib/rustlib").join(THUMB_TARGET).join("lib");
    let is_core = |name: &str| name.starts_with("libcore-") && name.ends_with(".rlib");
    std::fs::read_dir(libraries)
        .is_ok_and(|entries| entries.flatten().any(|entry| entry.file_name().to_str().is_some_and(is_core)))
}

#[cfg(test)]
#[path = "../tests/inside/setup.rs"]
mod tests;
