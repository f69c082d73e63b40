//! `cargo xtask log`: what a running board says over its debug probe, to the terminal and to a file.

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::process::Stdio;

use crate::provision::CHIP;
use crate::run::{self, Failure, command, step};
use crate::{board, setup};

/// Where the log goes.
const FILE: &str = "out/board.log";

/// Attaches without stopping or flashing the board; ends with Ctrl-C or when the probe is gone.
pub(crate) fn log() -> Result<(), Failure> {
    if !run::succeeds(&mut command("probe-rs", &["--version"])) {
        return Err(Failure::new("probe-rs is missing: `cargo install probe-rs-tools --locked` installs it"));
    }
    // The words of the log are in the image: it must be the one that was flashed.
    let ready = setup::setup()?;
    let image = step("image", || board::image(&ready))?;
    let path = run::root().join(FILE);
    let written = |cause: std::io::Error| Failure::new(format!("cannot write {FILE}: {cause}"));
    std::fs::create_dir_all(path.parent().unwrap_or(run::root())).map_err(written)?;
    let mut file = File::create(&path).map_err(written)?;
    let mut attach = command("probe-rs", &["attach", "--chip", CHIP]);
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
