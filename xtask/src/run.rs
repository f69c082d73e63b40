//! How chores call other programs, and how they fail.
//!
//! Everything runs in the workspace root, so that chores work from any directory. Progress goes to standard error;
//! standard output holds results only.

use std::env::consts::EXE_SUFFIX;
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{LazyLock, Mutex};
use std::time::Instant;

use crate::board::target;

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

/// The workspace root of the checkout that this runs in. Checkouts may share a target folder, so a path from when this was compiled may
/// lead into another one.
pub(crate) fn root() -> &'static Path {
    static ROOT: LazyLock<PathBuf> = LazyLock::new(|| {
        let manifest = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
        let here = std::env::current_dir().unwrap_or_default();
        checkout(manifest.as_deref(), &here).unwrap_or_else(|| {
            eprintln!(
                "error: no folder from {} upwards holds xtask/Cargo.toml; change into a checkout",
                here.display()
            );
            std::process::exit(1)
        })
    });
    &ROOT
}

/// The nearest folder with xtask/Cargo.toml: from the package that cargo runs upwards, or else from the current directory.
fn checkout(manifest: Option<&Path>, here: &Path) -> Option<PathBuf> {
    let mut folders = manifest.into_iter().chain([here]).flat_map(Path::ancestors);
    folders.find(|folder| folder.join("xtask/Cargo.toml").is_file()).map(Path::to_owned)
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

/// Has Clippy compile the project's own packages, so that they are linted on the way; a warning is an error. Whatever is compiled for the tests is
/// compiled so: otherwise cargo would compile it a second time.
pub(crate) fn linted(mut cargo: Command) -> Command {
    cargo.env("RUSTC_WORKSPACE_WRAPPER", "clippy-driver");
    cargo.env("CLIPPY_ARGS", "-D__CLIPPY_HACKERY__warnings__CLIPPY_HACKERY__");
    cargo
}

/// Builds cohold as the tests have it, or as a release, and gives the program.
pub(crate) fn cohold(release: bool) -> Result<PathBuf, Failure> {
    let words = ["build", "--locked", "--quiet", "--package", "cohold"];
    let (mut build, folder) = match release {
        true => (cargo(&[&words[..], &["--release"]].concat()), "release"),
        false => (linted(cargo(&words)), "debug"),
    };
    compile(&mut build)?;
    Ok(target().join(folder).join(format!("cohold{EXE_SUFFIX}")))
}

/// Cargo on everything that builds on a PC. Packages chosen together have one set of features, so what one call has built serves the
/// next; the emulator asks for a newer compiler than it needs.
pub(crate) fn everything(command: &str) -> Command {
    linted(cargo(&[command, "--locked", "--ignore-rust-version", "--workspace"]))
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

/// Whether a command succeeds, and what it says on standard output and then on standard error.
pub(crate) fn told(command: &mut Command) -> Result<(bool, String), Failure> {
    eprintln!("    {}", spelled(command));
    let output = command.output().map_err(|cause| cannot_run(command, &cause))?;
    let said = [output.stdout, output.stderr].concat();
    Ok((output.status.success(), String::from_utf8_lossy(&said).into_owned()))
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
pub(crate) fn not_checked(obstacle: &str) -> Result<(), Failure> {
    eprintln!("    NOT CHECKED: {obstacle}");
    Ok(())
}

/// Does this, or says why it cannot be done here.
pub(crate) fn unless(obstacle: Option<String>, work: impl FnOnce() -> Result<(), Failure>) -> Result<(), Failure> {
    obstacle.map_or_else(work, |obstacle| not_checked(&obstacle))
}

/// Fails where `CI` is set, and elsewhere says what is left out and why.
pub(crate) fn due_in_ci(obstacle: String) -> Result<(), Failure> {
    if std::env::var_os("CI").is_some() {
        return Err(Failure::new(obstacle));
    }
    not_checked(&obstacle)
}

/// What a step took.
struct Row {
    step: String,
    seconds: f64,
    /// Processor time of compilers and of all, s.
    compiled_s: f64,
    spent_s: f64,
}

/// The steps that were done so far.
static ROWS: Mutex<Vec<Row>> = Mutex::new(Vec::new());
/// Processor time of [`compile`] in the step at hand, s.
static COMPILED_S: Mutex<f64> = Mutex::new(0.0);
/// Nothing else is to begin: another lane has failed.
pub(crate) static STOP: AtomicBool = AtomicBool::new(false);

/// [`run`] of what compiles: the step's row tells it from the rest.
pub(crate) fn compile(command: &mut Command) -> Result<(), Failure> {
    let before = processor_s();
    let outcome = run(command);
    compiled_since(before);
    outcome
}

/// Counts what was spent since then as compiling.
pub(crate) fn compiled_since(before: Option<f64>) {
    if let (Some(now), Some(then), Ok(mut sum)) = (processor_s(), before, COMPILED_S.lock()) {
        *sum += now - then;
    }
}

/// Runs one step of a chore, with a line before it and its time after it.
pub(crate) fn step<T>(name: &str, work: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    if STOP.load(Ordering::Relaxed) {
        return Err(Failure::new(format!("{name}: not begun, for another lane has failed")));
    }
    let (start, before) = (Instant::now(), processor_s());
    eprintln!("==> {name}");
    let outcome = work().map_err(|failure| Failure(format!("{name}: {failure}"), failure.1));
    let verdict = if outcome.is_ok() { "done" } else { "FAILED" };
    let seconds = start.elapsed().as_secs_f64();
    let spent_s = processor_s().zip(before).map_or(0.0, |(now, then)| now - then);
    eprintln!("<== {name}: {verdict} in {seconds:.1} s, {spent_s:.1} s of processor time");
    let compiled_s = COMPILED_S.lock().map_or(0.0, |mut sum| std::mem::take(&mut *sum));
    if let Ok(mut rows) = ROWS.lock() {
        rows.push(Row { step: name.to_owned(), seconds, compiled_s, spent_s });
    }
    outcome
}

/// Says of a step that it need not run.
pub(crate) fn skipped(name: &str, when: &str) {
    eprintln!("==> {name}: passed on {when} with the same content");
}

/// Prints what each step took, and all of them together.
pub(crate) fn table() {
    let Ok(rows) = ROWS.lock() else { return };
    let row = |step: &str, numbers: [f64; 3]| {
        let [seconds, compiled_s, ran_s] = numbers.map(|number| format!("{number:>9.1}"));
        eprintln!("{step:<44} {seconds} {compiled_s} {ran_s}");
    };
    let (wall, cpu) = ("wall s", "processor s:");
    eprintln!("{:<44} {wall:>9} {cpu}\n{:<44} {:>9} {:>9} {:>9}", "step", "", "", "compile", "run");
    let of = |row: &Row| [row.seconds, row.compiled_s, (row.spent_s - row.compiled_s).max(0.0)];
    rows.iter().for_each(|one| row(&one.step, of(one)));
    let sum = |at: usize| rows.iter().map(|row| of(row)[at]).sum();
    row("all", [sum(0), sum(1), sum(2)]);
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

/// Processor time of everything on this machine since it started, s; only Linux tells. It counts what nobody waits for, too: a virtual board's
/// process is the child of another one's.
pub(crate) fn machine_s() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/stat").ok()?;
    let busy = text.lines().next()?.split_whitespace().skip(1).take(3).map(str::parse::<f64>);
    busy.sum::<Result<f64, _>>().ok().map(|ticks| ticks / 100.0)
}

#[cfg(test)]
#[path = "../tests/inside/run.rs"]
mod tests;
