//! `cargo xtask test`: everything that must pass before a change is taken. Stops at the first failure.
//!
//! Two lanes run side by side: the board's images with the virtual boards and then all that is built as a release, and the rest. A step that
//! passed on this machine with the same content does not run again ([`kept`]). Most steps run on everything that builds on a PC, whatever they
//! then choose of it, and Clippy is the compiler: so nothing is built twice. The check takes the machine as it is: what is missing is
//! installed. `Cargo.lock` is part of the project: a step that would have to change it fails.

use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::Ordering;
use std::time::Instant;
use std::{env, fs, thread};

use crate::kept::{self, Packages};
use crate::options::Options;
use crate::run::{self, Failure, STOP, cargo, compile, everything, run, step};
use crate::setup::{self, Ready, THUMB_TARGET};
use crate::{
    board, builds, count, homes, licences, no_panic, packages, page, platforms, python, qemu, readme, recordings, rig,
    rooms,
};

/// A step, by its name.
struct Step(&'static str, Runs, fn(&Ready, &Packages) -> Result<(), Failure>);
/// When a step runs.
enum Runs {
    Always,
    /// Unless it passed with what these packages, and these other files, hold; without packages, with all of them.
    Unless(&'static [&'static str], &'static [&'static str]),
    /// It consists of steps.
    Parts,
}
use Runs::{Always, Parts, Unless};

/// The lanes: the first of them runs in a process of its own beside the second.
const LANES: [&[Step]; 2] = [&BOARDS, &REST];
/// What they are called.
const NAMES: [&str; 2] = ["boards", "rest"];

/// All that is for the board's processor, the virtual boards last: their emulator takes minutes to build. Then, in a folder of its own, what is
/// built as a release: from `first build` on what a newcomer's first command builds.
const BOARDS: [Step; 10] = [
    Step(
        "rooms of the microcontroller",
        Unless(&["core", "protocol", "host-sim/guests/environments"], &[]),
        |ready, _| compile(&mut rooms_on_chip(ready)),
    ),
    // One image has the laws of other papers.
    Step("no-panic", Unless(&["firmware", "core/laws"], &[]), |ready, _| no_panic::no_panic(ready)),
    Step("lints of the images", Unless(&["firmware"], &RIG), |ready, _| lints_of_images(ready)),
    Step("virtual boards", Unless(&["firmware", "tests/board"], &RIG), |ready, _| {
        virtual_boards(ready, &board::images(ready)?)
    }),
    Step("qemu", Unless(&["host-sim"], &["tests/qemu"]), |ready, _| qemu(ready)),
    Step("first build", Always, |_, _| {
        let before = run::processor_s();
        compile(&mut first_build())?;
        builds::took("the first build", run::processor_s().zip(before).map(|(now, then)| now - then))
    }),
    Step("readme", Always, |_, _| readme::readme(true, None)),
    Step("golden traces", Always, |_, _| both_parts(|| as_released("golden"))),
    Step("reviewed tables", Unless(&["host-sim/studies"], &[]), |_, _| both_parts(|| as_released("reviewed"))),
    Step("bench-check", Unless(&["host-sim/cases"], &[]), |_, _| {
        run::unless(count::obstacle(), || count::ticks(false))
    }),
];

/// Everything else, cheapest first. Cargo has one folder for what it builds, and one lane waits while the other is in there: so what calls it in
/// debug stands before the tests, which run while the other lane builds its bench.
const REST: [Step; 12] = [
    Step("format", Always, |_, _| format()),
    Step("rooms", Always, |ready, _| rooms::rooms(&calls(ready), false)),
    Step("docs", Always, |_, _| {
        let looks = |words: &[&str]| run(&mut run::command("python3", words));
        looks(&["xtask/pages.py", "links"]).and_then(|()| looks(&["xtask/prose.py", "--check"]))
    }),
    Step("licences", Always, |_, _| licences::licences()),
    Step("page", Always, |_, _| page::browser().and_then(|()| page::page(false))),
    Step("platforms", Unless(&[], &[]), |_, _| platforms::check()),
    Step("tests", Parts, |_, packages| tests(packages)),
    Step("recordings", Unless(&["host-sim"], &["tests/recordings"]), |_, _| recordings::recordings()),
    Step("python", Unless(&["host-sim/python"], &["docs", "scenes", "examples"]), |_, _| python::python()),
    Step("packages", Unless(&["host-sim/python"], &[]), |_, _| packages::check()),
    Step("interleavings", Unless(&["firmware"], &[]), |_, _| both_parts(interleavings)),
    Step("homes", Unless(&["host-sim"], &[]), |_, _| run::unless(homes::obstacle(), homes::homes)),
];
/// The rig's image, without the tests of its list, which look at all there is.
const RIG: [&str; 4] = ["tests/rig/src", "tests/rig/Cargo.toml", "tests/rig/build.rs", "tests/rig/rig.x"];
/// Is set for the lane that another process waits for. It has no terminal, so it installs nothing that somebody might refuse.
pub(crate) const WAITED_FOR: &str = "COHOLD_CHECK_LANE";

/// Runs every step, or those of one lane, or one alone.
pub(crate) fn test(given: &Options<'_>) -> Result<(), Failure> {
    let (start, before) = (Instant::now(), run::machine_s());
    let only = given.value("--only");
    if given.flag("--anew") || only.is_some() {
        kept::anew();
    }
    let steps = || LANES.into_iter().flatten().map(|step| step.0);
    let one_of = |option: &str, allowed: &[&str]| match given.value(option) {
        Some(value) if !allowed.contains(&value) => {
            let list = allowed.join(", ");
            Err(Failure::usage(format!("{option} {value} is not allowed: it must be one of {list}")))
        }
        _ => Ok(()),
    };
    one_of("--lane", &NAMES)?;
    one_of("--only", &steps().collect::<Vec<_>>())?;
    let (ready, packages) = (step("set-up", setup::setup)?, Packages::read()?);
    let lane = given.value("--lane").and_then(|lane| NAMES.iter().position(|name| *name == lane));
    // Both lanes need programs of Debian's; only this one may ask.
    if lane.is_none() {
        let _ = (qemu::obstacle(), count::obstacle());
    }
    match (only, lane) {
        (None, None) => both(given, &ready, &packages)?,
        (only, lane) => {
            let lanes = lane.map_or(&LANES[..], |lane| &LANES[lane..=lane]);
            let chosen = |step: &&Step| only.is_none_or(|only| step.0 == only);
            alone(&lanes.iter().copied().flatten().filter(chosen).collect::<Vec<_>>(), &ready, &packages)?;
        }
    }
    let spent = run::machine_s().zip(before).map(|(now, then)| now - then);
    let spent =
        spent.map_or(String::new(), |spent| format!("; {spent:.0} s of processor time on this machine meanwhile"));
    eprintln!("passed in {:.0} s{spent}", start.elapsed().as_secs_f64());
    Ok(())
}

/// Runs the second lane, and beside it the first, whose words are printed when it has ended.
fn both(given: &Options<'_>, ready: &Ready, packages: &Packages) -> Result<(), Failure> {
    let words = board::target().join("check-boards.txt");
    let failed = |cause| Failure::new(format!("cannot begin the lane {}: {cause}", NAMES[0]));
    fs::create_dir_all(board::target()).map_err(failed)?;
    // Beside it are tests that keep time.
    let mut lane = Command::new("nice");
    lane.arg("-n10")
        .arg(env::current_exe().map_err(failed)?)
        .args(["test", "--lane", NAMES[0]])
        .args(given.flag("--anew").then_some("--anew"))
        .env(WAITED_FOR, "1");
    let file = fs::File::create(&words).map_err(failed)?;
    lane.stdin(Stdio::piped()).stdout(file.try_clone().map_err(failed)?).stderr(file);
    let mut lane = lane.spawn().map_err(failed)?;
    eprintln!("    beside this: the lane {}, which writes to {}", NAMES[0], words.display());
    // While this is open, the lane goes on.
    let open = lane.stdin.take();
    let ended = thread::spawn(move || {
        let passed = lane.wait().is_ok_and(|status| status.success());
        STOP.fetch_or(!passed, Ordering::Relaxed);
        passed
    });
    let ours = alone(&LANES[1].iter().collect::<Vec<_>>(), ready, packages);
    if ours.is_err() {
        drop(open);
    }
    let theirs = ended.join().unwrap_or(false);
    eprintln!("==> the lane {}, from {}", NAMES[0], words.display());
    eprint!("{}", String::from_utf8_lossy(&fs::read(&words).unwrap_or_default()));
    match (ours, theirs) {
        (Ok(()), false) => Err(Failure::new(format!("the lane {} failed (see above)", NAMES[0]))),
        (ours, _) => ours,
    }
}

/// Runs the steps of a lane and says what each took. A lane that somebody waits for begins no step after he has gone.
fn alone(steps: &[&Step], ready: &Ready, packages: &Packages) -> Result<(), Failure> {
    if env::var_os(WAITED_FOR).is_some() {
        thread::spawn(|| {
            let _ = std::io::stdin().read(&mut [0]);
            STOP.store(true, Ordering::Relaxed);
        });
    }
    let outcome = steps.iter().try_for_each(|Step(name, runs, work)| {
        let work = || work(ready, packages);
        match runs {
            Always => step(name, work),
            Unless(of, others) => packages.step(name, of, others, work),
            Parts => work(),
        }
    });
    run::table();
    outcome
}

/// Builds tests, and runs them.
fn both_parts(tests: fn() -> Command) -> Result<(), Failure> {
    compile(tests().arg("--no-run"))?;
    run(&mut tests())
}

/// Builds all tests in debug but those of the virtual boards, and runs each package's that is not known to pass. Parts of the image that need
/// no chip and the programs of examples/ are included.
fn tests(packages: &Packages) -> Result<(), Failure> {
    let name = |folder: &str| format!("tests of {folder}");
    // These two look at all there is.
    let others = |folder: &str| if ["xtask", "tests/rig"].contains(&folder) { ["."].as_slice() } else { &[] };
    let folders: Vec<&str> = packages.folders().filter(|folder| *folder != "tests/board").collect();
    let inputs: Vec<_> =
        folders.iter().map(|folder| packages.inputs(&[folder], others(folder))).collect::<Result<_, _>>()?;
    let mut programs = Vec::new();
    if folders.iter().zip(&inputs).any(|(folder, inputs)| kept::passed(&name(folder), inputs).is_none()) {
        programs = step("tests, debug: build", build_tests)?;
    }
    kept::step("tests of documentation", &packages.inputs(&["host-sim"], &[])?, || run(debug_tests().arg("--doc")))?;
    for (folder, inputs) in folders.iter().zip(&inputs) {
        let here = run::root().join(folder);
        let own = programs.iter().filter(|(manifest, _)| manifest.parent() == Some(&here));
        kept::step(&name(folder), inputs, || {
            own.clone().try_for_each(|(_, program)| {
                // Some have cargo build more.
                let mut test = run::linted(run::command(&program.to_string_lossy(), &[]));
                undisturbed(test.current_dir(&here).env("CARGO_MANIFEST_DIR", &here))
            })
        })?;
    }
    Ok(())
}

/// What a peer at a device says if this machine was too busy for it.
const TOO_BUSY: [&str; 4] = ["stood still for", "of 50 allowed", "of 100 allowed", "newest place is"];

/// Runs a program of tests. Failed tests in which a peer says that this machine was too busy run again, twice at the
/// most, without the others.
fn undisturbed(test: &mut Command) -> Result<(), Failure> {
    let (passed, said) = run::told(test)?;
    eprint!("{said}");
    let failed: Vec<&str> = said.lines().filter_map(failed_test).collect();
    match passed {
        true => Ok(()),
        false if !failed.is_empty() && TOO_BUSY.iter().any(|words| said.contains(words)) => {
            let alone = test.arg("--exact").args(failed);
            run(alone).or_else(|_| run(alone))
        }
        false => Err(Failure::new(format!("`{}` failed", run::spelled(test)))),
    }
}

/// The name of a test that failed, from the line that says so.
fn failed_test(line: &str) -> Option<&str> {
    line.strip_prefix("test ")?.strip_suffix(" ... FAILED")
}

/// The manifests and programs of all tests in debug, which are built.
fn build_tests() -> Result<Vec<(PathBuf, PathBuf)>, Failure> {
    let mut build = debug_tests();
    build.args(["--no-run", "--message-format", "json-render-diagnostics"]);
    eprintln!("    {}", run::spelled(&build));
    let before = run::processor_s();
    let built = run::output(&mut build)?;
    run::compiled_since(before);
    let field = |line: &str, name: &str| {
        let (_, rest) = line.split_once(&format!("\"{name}\":\""))?;
        Some(PathBuf::from(rest.split_once('"')?.0))
    };
    let tests = built.lines().filter(|line| line.contains("\"test\":true}"));
    Ok(tests.filter_map(|line| field(line, "manifest_path").zip(field(line, "executable"))).collect())
}

/// What `cargo xtask test` has cargo compile, without the few crates of tests/qemu.
pub(crate) fn calls(ready: &Ready) -> Vec<Command> {
    let mut calls = vec![first_build(), debug_tests(), as_released("golden"), as_released("reviewed")];
    calls.extend([
        interleavings(),
        count::bench(),
        board::bench(&["test"], Path::new("")),
        run::linted(cargo(&["build", "--locked", "--package", "cohold-python"])),
    ]);
    calls.extend(platforms::calls());
    calls.push(rooms_on_chip(ready));
    for features in board::IMAGES {
        calls.extend(["build", "rustc"].map(|what| board::build(ready, what, features)));
        calls.push(no_panic::link(ready, "proof", features));
    }
    calls.push(no_panic::link(ready, "planted-panic", board::IMAGES[0]));
    calls.extend(["build", "rustc"].map(|what| rig::build(ready, what)));
    calls
}

/// Runs what tells soonest whether a small change is good: format, who leans on whom, unit tests with lints, golden traces.
pub(crate) fn quick() -> Result<(), Failure> {
    step("format", format)?;
    step("rooms", || rooms::rooms(&[], false))?;
    step("unit tests", || run(everything("test").args(["--lib", "--bins"])))?;
    step("golden traces", || run(everything("test").args(["--test", "golden"])))
}

fn format() -> Result<(), Failure> {
    run(&mut cargo(&["fmt", "--all", "--check"])).map_err(|failure| advice(&failure, "`cargo fmt --all` mends it"))
}

/// Everything that builds on a PC but the virtual boards, whose emulator takes minutes.
pub(crate) fn debug_tests() -> Command {
    let mut tests = everything("test");
    tests.args(["--exclude", "board-bench"]);
    tests
}

/// Core, protocol and the roles of the environments for the microcontroller. As the image is: what they need is not built twice.
fn rooms_on_chip(ready: &Ready) -> Command {
    let mut build = ready.cargo(&["build", "--locked", "--profile", "firmware", "--target", THUMB_TARGET]);
    build.args(["--package", "cohold-core", "--package", "cohold-protocol"]);
    build.args(["--package", "cohold-environments", "--no-default-features"]);
    build
}

/// A newcomer's first build.
pub(crate) fn first_build() -> Command {
    cargo(&["build", "--locked", "--release"])
}

/// Tests of this name as a release computes them, on what the first build has compiled: golden traces are the same bits in every build, and tables
/// from thousands of runs take a part of the time.
fn as_released(name: &str) -> Command {
    cargo(&["test", "--locked", "--release", "--test", name])
}

/// The memory that interrupt and tasks share, under loom, which runs every order that its operations can have.
fn interleavings() -> Command {
    let mut loom = everything("test");
    loom.args(["--features", "firmware/loom", "--test", "interleavings"]);
    loom
}

/// cohold-core on another model of the processor; without one it says so, and fails where CI is set.
fn qemu(ready: &Ready) -> Result<(), Failure> {
    qemu::obstacle().map_or_else(|| qemu::qemu(ready), run::due_in_ci)
}

/// What the lints of what builds on a PC do not reach: the images.
fn lints_of_images(ready: &Ready) -> Result<(), Failure> {
    if ready.fallback {
        // Debian's toolchain has no clippy of its own.
        return run::not_checked("the images, their toolchain is Debian's");
    }
    for features in board::IMAGES {
        compile(&mut unlinked(board::build(ready, "rustc", features)))?;
    }
    compile(&mut unlinked(rig::build(ready, "rustc")))
}

/// Clippy compiles an image upon the libraries that it has, and links nothing: they are not compiled a second time, and the image stays where it is.
fn unlinked(image: Command) -> Command {
    let mut lints = run::linted(image);
    lints.args("-- -C linker=true -C lto=off -C opt-level=0 -C debug-assertions=off".split(' '));
    lints
}

/// The release image on virtual boards, beside the rig's first.
fn virtual_boards(ready: &Ready, image: &Path) -> Result<(), Failure> {
    compile(&mut board::bench(&["test", "--no-run"], image))?;
    rig::on_virtual_boards(ready, image, &[])?;
    run(&mut board::bench(&["test"], image))
}

/// The analyser's verdicts beside runs, or the curve of its limits, by the tests of its package.
pub(crate) fn verdicts(given: &Options<'_>) -> Result<(), Failure> {
    let test = if given.flag("--limits") { "curve::" } else { "verdicts::" };
    let mut tests = cargo(&["test", "--locked", "--release", "--package", "cohold-analysis", "--test", "suite", test]);
    tests.env("LIMITS", "all").env("SCENES", given.value("--scenes").unwrap_or("10000"));
    run(tests.env("SEED", given.value("--seed").unwrap_or("0")).args(["--", "--nocapture"]))
}

fn advice(failure: &Failure, advice: &str) -> Failure {
    Failure::new(format!("{failure}; {advice}"))
}

#[cfg(test)]
#[path = "../tests/inside/test.rs"]
mod tests;
