//! What goes over a board's debug probe.
//!
//! `cargo xtask log`: what a running board says, to the terminal and to a file.
//!
//! `cargo xtask provision`: gives a board the key that it shares with its peer, and its operator's. They go into a flash sector
//! of their own, at the address that memory.x calls KEY; flashing an image leaves them there. Their image exists as a file
//! only for as long as that takes.

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{Command, Stdio};

use crate::options::Options;
use crate::run::{self, Failure, cargo, command, run, step};
use crate::{board, setup};

/// Where the log goes.
const LOG: &str = "out/board.log";

/// probe-rs is there.
fn is_there() -> Result<(), Failure> {
    if run::succeeds(&mut command("probe-rs", &["--version"])) {
        return Ok(());
    }
    Err(Failure::new("probe-rs is missing: `cargo install probe-rs-tools --locked` installs it"))
}

/// probe-rs, if it is there, on the project's chip.
pub(crate) fn probe_rs(verb: &str, probe: Option<&str>) -> Result<Command, Failure> {
    is_there()?;
    let mut command = command("probe-rs", &[verb, "--chip", "STM32H743ZITx"]);
    command.args(probe.into_iter().flat_map(|probe| ["--probe", probe]));
    Ok(command)
}

/// The probes that are connected, each as probe-rs takes it: VID:PID:SERIAL.
pub(crate) fn connected() -> Result<Vec<String>, Failure> {
    is_there()?;
    Ok(probes(&run::output(&mut command("probe-rs", &["list"]))?))
}

/// The probes in what `probe-rs list` says, such as `[0]: STLink V3 -- 0483:374e:0042003A (ST-LINK)`.
pub(crate) fn probes(list: &str) -> Vec<String> {
    let words = list.lines().filter_map(|line| line.rsplit_once(" -- ")?.1.split(' ').next());
    words.filter(|word| serial(word).is_some()).map(str::to_owned).collect()
}

/// The serial number of a probe.
pub(crate) fn serial(probe: &str) -> Option<&str> {
    probe.splitn(3, ':').nth(2).filter(|serial| !serial.is_empty())
}

/// Attaches without flashing the board; ends with Ctrl-C or when the probe is gone.
pub(crate) fn log(given: &Options) -> Result<(), Failure> {
    let mut attach = probe_rs("attach", given.value("--probe"))?;
    // The words of the log are in the image: it must be the one that was flashed.
    let ready = setup::setup()?;
    let image = step("image", || board::image(&ready))?;
    let path = run::root().join(LOG);
    let written = |cause: std::io::Error| Failure::new(format!("cannot write {LOG}: {cause}"));
    std::fs::create_dir_all(path.parent().unwrap_or(run::root())).map_err(written)?;
    let file = File::options().create(true).append(true).open(&path);
    let mut file = file.map_err(written)?;
    let mut probe = (attach.arg(&image).stdout(Stdio::piped()).spawn())
        .map_err(|cause| Failure::new(format!("cannot run probe-rs: {cause}")))?;
    for line in probe.stdout.take().into_iter().flat_map(|stdout| BufReader::new(stdout).lines()).map_while(Result::ok)
    {
        println!("{line}");
        // Line by line: an experiment that ends with a pulled plug leaves its log.
        writeln!(file, "{line}").and_then(|()| file.flush()).map_err(written)?;
    }
    match probe.wait() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(Failure::new(format!("probe-rs ended with {status}; is the board connected and flashed?"))),
        Err(cause) => Err(Failure::new(format!("cannot wait for probe-rs: {cause}"))),
    }
}

/// Makes the image of the keys, puts it on the board and starts the board anew.
pub(crate) fn provision(given: &Options<'_>) -> Result<(), Failure> {
    let file = |option| given.value(option).ok_or_else(|| Failure::usage(format!("{option} FILE is needed")));
    let (peers, operator) = (file("--key-file")?, file("--operator-key-file")?);
    let probe = given.value("--probe");
    let (mut download, mut reset) = (probe_rs("download", probe)?, probe_rs("reset", probe)?);
    let address = address()?;
    let here = std::env::current_dir().map_err(|cause| Failure::new(format!("no working directory: {cause}")))?;
    let image = Image(run::root().join("target").join(format!("key-{}.bin", std::process::id())));
    let mut make = cargo(&["run", "--quiet", "--locked", "--package", "cohold", "--", "key", "image"]);
    make.arg("--key-file").arg(here.join(peers)).arg("--operator-key-file").arg(here.join(operator));
    run(make.arg(&image.0))?;
    run(download.args(["--verify", "--binary-format", "bin", "--base-address", &address]).arg(&image.0))?;
    run(&mut reset)
}

/// A file with keys in it, gone when dropped.
struct Image(PathBuf);

impl Drop for Image {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// Where memory.x puts the keys.
fn address() -> Result<String, Failure> {
    let text = run::read(&run::root().join("memory.x"))?;
    let line = text.lines().find(|line| line.trim_start().starts_with("KEY ") && line.contains("ORIGIN"));
    let address = line.and_then(|line| line.split_once("ORIGIN = ")?.1.split_once(',')).map(|(address, _)| address);
    address.map(str::to_owned).ok_or_else(|| Failure::new("memory.x names no KEY"))
}

#[cfg(test)]
#[path = "../tests/inside/probe.rs"]
mod tests;
