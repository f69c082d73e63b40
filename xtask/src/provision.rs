//! `cargo xtask provision`: gives a board the key that it shares with its peer and its operator.
//!
//! The key goes into a flash sector of its own, at the address that memory.x calls KEY, over the debug probe; flashing an
//! image leaves it there. The image of the key exists as a file only for as long as that takes.

use std::path::PathBuf;

use crate::run::{self, Failure, cargo, command, run};

/// The chip, as probe-rs calls it.
pub(crate) const CHIP: &str = "STM32H743ZITx";

/// Which key, and onto which board.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Plan<'a> {
    key_file: &'a str,
    probe: Option<&'a str>,
}

impl<'a> Plan<'a> {
    /// Reads the command line.
    pub(crate) fn parse(arguments: &[&'a str]) -> Result<Self, Failure> {
        let (mut key_file, mut probe) = (None, None);
        let mut rest = arguments;
        while let [name, value, more @ ..] = rest {
            match *name {
                "--key-file" => key_file = Some(*value),
                "--probe" => probe = Some(*value),
                _ => break,
            }
            rest = more;
        }
        match (key_file, rest) {
            (Some(key_file), []) => Ok(Self { key_file, probe }),
            _ => Err(Failure::usage("usage: cargo xtask provision --key-file FILE [--probe VID:PID[:SERIAL]]")),
        }
    }
}

/// Makes the image, puts it on the board and starts the board anew.
pub(crate) fn provision(arguments: &[&str]) -> Result<(), Failure> {
    let Plan { key_file, probe } = Plan::parse(arguments)?;
    if !run::succeeds(&mut command("probe-rs", &["--version"])) {
        return Err(Failure::new("probe-rs is missing: `cargo install probe-rs-tools --locked` installs it"));
    }
    let address = address()?;
    let here = std::env::current_dir().map_err(|cause| Failure::new(format!("no working directory: {cause}")))?;
    let image = Image(run::root().join("target").join(format!("key-{}.bin", std::process::id())));
    let mut make = cargo(&["run", "--quiet", "--locked", "--package", "host-sim", "--", "key", "image"]);
    run(make.arg(here.join(key_file)).arg(&image.0))?;
    let on = |verb: &str| {
        let mut on = command("probe-rs", &[verb, "--chip", CHIP]);
        if let Some(probe) = probe {
            on.args(["--probe", probe]);
        }
        on
    };
    run(on("download").args(["--verify", "--binary-format", "bin", "--base-address", &address]).arg(&image.0))?;
    run(&mut on("reset"))
}

/// A file with a key in it, gone when dropped.
struct Image(PathBuf);

impl Drop for Image {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// Where memory.x puts the key.
fn address() -> Result<String, Failure> {
    let text = std::fs::read_to_string(run::root().join("memory.x"))
        .map_err(|cause| Failure::new(format!("cannot read memory.x: {cause}")))?;
    let line = text.lines().find(|line| line.trim_start().starts_with("KEY ") && line.contains("ORIGIN"));
    let address = line.and_then(|line| line.split_once("ORIGIN = ")?.1.split_once(',')).map(|(address, _)| address);
    address.map(str::to_owned).ok_or_else(|| Failure::new("memory.x names no KEY"))
}

#[cfg(test)]
#[path = "../tests/inside/provision.rs"]
mod tests;
