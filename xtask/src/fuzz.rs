//! `cargo xtask fuzz`: every fuzz target of a package's `fuzz` for a while, with the corpus that earlier runs left.
//!
//! The targets are libFuzzer's, built as cargo-fuzz would build them but for the address sanitizer: there is no unsafe code in
//! what they call, so coverage and overflow checks are all they need. That makes the project's own toolchain and a C++
//! compiler (libFuzzer is C++) enough: no nightly, nothing to install.
//!
//! Inputs that reach something new are kept: those that reach code that nothing in `fuzz/corpus` does are merged into it.
//! An input that crashes a target is left in `fuzz/artifacts`, and the command that runs it again is printed.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use crate::options::Options;
use crate::run::{self, Failure, cargo, command, step};

/// Folders of targets, and the manifests that name these.
const FOLDERS: [(&str, &str); 5] = [
    ("protocol/fuzz", include_str!("../../protocol/fuzz/Cargo.toml")),
    ("host-sim/guests/environments/fuzz", include_str!("../../host-sim/guests/environments/fuzz/Cargo.toml")),
    ("host-sim/live/fuzz", include_str!("../../host-sim/live/fuzz/Cargo.toml")),
    ("host-sim/guests/homes/fuzz", include_str!("../../host-sim/guests/homes/fuzz/Cargo.toml")),
    ("host-sim/guests/page/fuzz", include_str!("../../host-sim/guests/page/fuzz/Cargo.toml")),
];
/// Time for each target by default, s.
const SECONDS: u32 = 60;
/// Longest time for each target, s.
const MOST_SECONDS: u32 = 86_400;
/// An input that takes longer is a crash, s: nothing that others send may keep anybody busy.
const LONGEST: &str = "-timeout=10";
/// Coverage counters and comparisons that libFuzzer steers by, and checks that a release build leaves out.
const FLAGS: &str = "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
                     -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
                     -Cllvm-args=-sanitizer-coverage-trace-compares -Cdebug-assertions -Ccodegen-units=1 --cfg fuzzing";

/// A target: its folder and its name.
type Target = (&'static str, &'static str);

/// Every target.
fn targets() -> Vec<Target> {
    let named = |bin: &'static str| bin.lines().find_map(|line| line.strip_prefix("name = \"")?.strip_suffix('"'));
    let of = |(folder, manifest): (_, &'static str)| {
        manifest.split("[[bin]]").skip(1).filter_map(named).map(move |name| (folder, name))
    };
    FOLDERS.into_iter().flat_map(of).collect()
}

/// The targets that are asked for, and the seconds for each.
fn plan(given: &Options<'_>) -> Result<(Vec<Target>, u32), Failure> {
    let not_allowed = |option: &str, value: &str, allowed: String| {
        Failure::usage(format!("{option} \"{value}\" is not allowed: it must be {allowed}"))
    };
    let seconds = given.value("--seconds").map_or(Ok(SECONDS), |value| {
        let seconds = value.parse().ok().filter(|seconds| (1..=MOST_SECONDS).contains(seconds));
        seconds.ok_or_else(|| not_allowed("--seconds", value, format!("a whole number from 1 to {MOST_SECONDS}")))
    })?;
    let Some(value) = given.value("--target") else { return Ok((targets(), seconds)) };
    let known = targets().into_iter().find(|(_, known)| *known == value);
    let names: Vec<&str> = targets().into_iter().map(|(_, name)| name).collect();
    let target = known.ok_or_else(|| not_allowed("--target", value, format!("one of {}", names.join(", "))))?;
    Ok((vec![target], seconds))
}

/// Builds the targets and runs them one after the other.
pub(crate) fn fuzz(given: &Options<'_>) -> Result<(), Failure> {
    let (targets, seconds) = plan(given)?;
    let mut rows = Vec::new();
    for (folder, _) in FOLDERS {
        let of_folder: Vec<&str> = targets.iter().filter(|(of, _)| *of == folder).map(|(_, target)| *target).collect();
        if of_folder.is_empty() {
            continue;
        }
        let binaries = step(&format!("build {folder}"), || build(folder))?;
        for target in of_folder {
            rows.push(step(target, || run_one(&binaries, folder, target, seconds))?);
        }
    }
    println!("| fuzz target | seconds | executions | inputs kept | new among them |\n|---|---:|---:|---:|---:|");
    for row in rows {
        println!("{row}");
    }
    Ok(())
}

/// Builds the targets of a folder; gives the folder of the binaries.
fn build(folder: &str) -> Result<PathBuf, Failure> {
    let host = run::output(&mut command("rustc", &["-vV"]))?;
    let host = host
        .lines()
        .find_map(|line| line.strip_prefix("host: "))
        .ok_or_else(|| Failure::new("`rustc -vV` does not say what it builds for"))?;
    let target = match env::var_os("CARGO_TARGET_DIR") {
        Some(shared) => run::root().join(shared).join("fuzz"),
        None => run::root().join(folder).join("target"),
    };
    let manifest = format!("{folder}/Cargo.toml");
    let mut build = cargo(&["build", "--locked", "--release", "--manifest-path", &manifest]);
    // With a target named, build scripts are left without the counters, which are nothing to them.
    build.args(["--target", host]).env("RUSTFLAGS", FLAGS).env("CARGO_TARGET_DIR", &target);
    run::run(&mut build).map_err(|failure| {
        Failure::new(format!("{failure}; libFuzzer needs a C++ compiler (`apt-get install g++`)"))
    })?;
    Ok(target.join(host).join("release"))
}

/// Runs one target, keeps what it found; a line of the table.
fn run_one(binaries: &Path, folder: &str, target: &str, seconds: u32) -> Result<String, Failure> {
    let binary = binaries.join(target);
    let fuzz = run::root().join(folder);
    let (corpus, artifacts) = (fuzz.join("corpus").join(target), fuzz.join("artifacts").join(target));
    let found = binaries.join("found").join(target);
    // What an earlier run found was merged then, or is found again.
    let _ = std::fs::remove_dir_all(&found);
    for folder in [&corpus, &artifacts, &found] {
        std::fs::create_dir_all(folder)
            .map_err(|cause| Failure::new(format!("cannot make {}: {cause}", folder.display())))?;
    }
    let before = count(&corpus);
    let start = Instant::now();
    let mut libfuzzer = Command::new(&binary);
    libfuzzer.args([&found, &corpus]).arg(format!("-max_total_time={seconds}")).args([LONGEST, "-print_final_stats=1"]);
    let said = quietly(libfuzzer.arg(format!("-artifact_prefix={}/", artifacts.display())), || {
        format!(
            "{target} crashed (see above): `{} {}/FILE` runs the input again; mend the cause and keep the input in {}",
            binary.display(),
            artifacts.display(),
            corpus.display()
        )
    })?;
    let spent = start.elapsed().as_secs();
    let executions = said.lines().find_map(|line| line.strip_prefix("stat::number_of_executed_units:"));
    let executions = executions.map(str::trim).ok_or_else(|| {
        Failure::new(format!("{target} did not say how often it ran: has libFuzzer's output changed?"))
    })?;
    // As few as reach all that is reached: how often something is reached is left to the next run to find again.
    let merge = ["-set_cover_merge=1", "-use_counters=0"];
    quietly(Command::new(&binary).args(merge).args([&corpus, &found]), || {
        format!("what {target} found could not be merged into {}", corpus.display())
    })?;
    // Nothing in it: no crash.
    let _ = std::fs::remove_dir(&artifacts).and_then(|()| std::fs::remove_dir(fuzz.join("artifacts")));
    let after = count(&corpus);
    Ok(format!("| {target} | {spent} | {executions} | {after} | {} |", after.saturating_sub(before)))
}

/// Runs and gives what went to standard error, which is shown only when it failed.
fn quietly(command: &mut Command, failed: impl Fn() -> String) -> Result<String, Failure> {
    let (succeeded, said) = run::told(command)?;
    if succeeded {
        return Ok(said);
    }
    eprintln!("{said}");
    Err(Failure::new(failed()))
}

/// Files in a folder.
fn count(folder: &Path) -> usize {
    std::fs::read_dir(folder).map_or(0, |entries| entries.flatten().count())
}

#[cfg(test)]
#[path = "../tests/inside/fuzz.rs"]
mod tests;
