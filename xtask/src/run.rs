//! How chores call other programs, and how they fail.
//!
//! Everything runs in the workspace root, so that chores work from any directory. Progress goes to standard error;
//! standard output holds results only.

use std::fmt;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

/// Why a chore stopped: what failed and what to do about it, in one line, and the exit status.
#[derive(Debug)]
pub(crate) struct Failure(String, u8);

impl Failure {
    /// Says what failed and what to do.
    pub(crate) fn new(what: impl Into<String>) -> Self {
        Self(what.into(), 1)
    }

    /// The command line is wrong.
    pub(crate) fn usage(what: impl Into<String>) -> Self {
        Self(what.into(), 2)
    }

    /// Says it, unless that was done; gives the exit status.
    pub(crate) fn report(self) -> ExitCode {
        if !self.0.is_empty() {
            eprintln!("error: {self}");
        }
        ExitCode::from(self.1)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Has cargo compile what computes a tick as a release compiles it, and nothing else anew.
pub(crate) const AS_RELEASED: [&str; 2] = ["--config", "xtask/as-released.toml"];

/// The workspace root.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."))
}

/// A program with its arguments, to be run in the workspace root.
pub(crate) fn command(program: &str, arguments: &[&str]) -> Command {
    let mut command = Command::new(program);
    command.args(arguments).current_dir(root());
    // What cargo tells a program of its package, build scripts heed as well: what was built from the command line would be
    // built again from here, and the other way round.
    let of_package = |name: &str| name.starts_with("CARGO_PKG_") || name.starts_with("CARGO_MANIFEST_");
    for (name, _) in std::env::vars_os().filter(|(name, _)| name.to_str().is_some_and(of_package)) {
        command.env_remove(name);
    }
    command
}

/// Cargo, as the toolchain file chooses it.
pub(crate) fn cargo(arguments: &[&str]) -> Command {
    command("cargo", arguments)
}

/// Cargo on everything that builds on a PC. Packages chosen together have one set of features, so what one call has built serves the
/// next; the emulator asks for a newer compiler than it needs.
pub(crate) fn everything(command: &str) -> Command {
    cargo(&[command, "--locked", "--ignore-rust-version", "--workspace"])
}

/// A command as one would type it.
pub(crate) fn spelled(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    words.map(|word| word.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ")
}

/// Runs a command, its output passing through to standard error; anything but success is a failure.
pub(crate) fn run(command: &mut Command) -> Result<(), Failure> {
    eprintln!("    {}", spelled(command));
    let status = command.stdout(std::io::stderr()).status().map_err(|cause| cannot_run(command, &cause))?;
    if status.success() { Ok(()) } else { Err(Failure::new(format!("`{}` failed ({status})", spelled(command)))) }
}

/// What a command prints on standard output; anything but success is a failure.
pub(crate) fn output(command: &mut Command) -> Result<String, Failure> {
    output_up_to(command, 0)
}

/// The same of a command whose exit status may be up to this.
pub(crate) fn output_up_to(command: &mut Command, most: i32) -> Result<String, Failure> {
    let output = command.stderr(Stdio::inherit()).output().map_err(|cause| cannot_run(command, &cause))?;
    if output.status.code().is_some_and(|code| (0..=most).contains(&code)) {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        Err(Failure::new(format!("`{}` failed ({})", spelled(command), output.status)))
    }
}

/// Whether a command succeeds, and what it says on standard error.
pub(crate) fn told(command: &mut Command) -> Result<(bool, String), Failure> {
    eprintln!("    {}", spelled(command));
    let output = command.output().map_err(|cause| cannot_run(command, &cause))?;
    Ok((output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned()))
}

/// The text of a file.
pub(crate) fn read(path: &Path) -> Result<String, Failure> {
    std::fs::read_to_string(path).map_err(|cause| Failure::new(format!("cannot read {}: {cause}", path.display())))
}

/// Whether a command runs and succeeds; its output is thrown away.
pub(crate) fn succeeds(command: &mut Command) -> bool {
    command.stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok_and(|status| status.success())
}

fn cannot_run(command: &Command, cause: &std::io::Error) -> Failure {
    Failure::new(format!("cannot run {}: {cause}; is it installed?", command.get_program().to_string_lossy()))
}

/// Says what is left out and why.
pub(crate) fn not_checked(obstacle: &str) {
    eprintln!("    NOT CHECKED: {obstacle}");
}

/// Fails where `CI` is set, and elsewhere says what is left out and why.
pub(crate) fn due_in_ci(obstacle: String) -> Result<(), Failure> {
    if std::env::var_os("CI").is_some() {
        return Err(Failure::new(obstacle));
    }
    not_checked(&obstacle);
    Ok(())
}

/// Runs one step of a chore, with a line before it and its time after it.
pub(crate) fn step<T>(name: &str, work: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    let (start, spent) = (Instant::now(), processor_s());
    eprintln!("==> {name}");
    let outcome = work().map_err(|failure| Failure(format!("{name}: {failure}"), failure.1));
    let verdict = if outcome.is_ok() { "done" } else { "FAILED" };
    let spent = processor_s()
        .zip(spent)
        .map_or(String::new(), |(now, then)| format!(", {:.1} s of processor time", now - then));
    eprintln!("<== {name}: {verdict} in {:.1} s{spent}", start.elapsed().as_secs_f64());
    outcome
}

/// Processor time of all programs that were called and have ended, s; only Linux tells.
pub(crate) fn processor_s() -> Option<f64> {
    let line = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The name of the program, in brackets, may hold blanks: what counts stands behind it.
    let mut fields = line.rsplit_once(')')?.1.split_whitespace().skip(13);
    let mut ticks = || fields.next()?.parse::<f64>().ok();
    // Linux counts hundredths of a second here, whatever its own clock does.
    Some((ticks()? + ticks()?) / 100.0)
}
