//! `cargo xtask rig`: what two bare boards are to show on silicon. List and page are a package of their own, tests/rig; the bench (tests/board)
//! runs it on two virtual boards, or on two that are on a table.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use crate::board::{self, bench, target};
use crate::options::Options;
use crate::probe;
use crate::run::{self, Failure, cargo, command, run, step};
use crate::setup::{self, Ready, THUMB_TARGET};

/// Where Linux names serial ports by who is behind them.
const PORTS: &str = "/dev/serial/by-id";
/// The first board's address, as it is delivered.
const ADDRESS: &str = "192.168.77.1";

/// Prints what each test would do, writes docs/results/hardware.md, or runs the list.
pub(crate) fn rig(given: &Options<'_>) -> Result<(), Failure> {
    if let Some(boards) = given.value("--boards") {
        return on_a_table(given, boards);
    }
    if given.flag("--virtual") {
        let ready = step("set-up", setup::setup)?;
        let firmware = step("image", || board::image(&ready))?;
        return step("rig", || on_virtual_boards(&ready, &firmware, &which(given)));
    }
    if given.flag("--page") {
        return run(&mut rig_of(&["--", "--page"]));
    }
    plan()
}

/// The program of tests/rig.
fn rig_of(words: &[&str]) -> Command {
    let mut rig = cargo(&["run", "--quiet", "--locked", "--package", "cohold-rig", "--bin", "cohold-rig"]);
    rig.args(words);
    rig
}

fn plan() -> Result<(), Failure> {
    print!("{}", run::output(&mut rig_of(&[]))?);
    Ok(())
}

/// Two boards that are there, and how to reach them.
#[derive(Debug, PartialEq, Eq)]
struct Found {
    /// Probes of the board under test and of the rig, as probe-rs takes them.
    probes: [String; 2],
    port: PathBuf,
}

/// Finds two boards by the serial numbers of their probes, in what is connected, and the rig's port; or says all that is missing.
fn find(boards: [&str; 2], connected: &[String], port: Option<PathBuf>) -> Result<Found, String> {
    let there = connected.iter().filter_map(|probe| probe::serial(probe)).collect::<Vec<_>>().join(", ");
    let there = if there.is_empty() { "none is connected".to_owned() } else { format!("connected: {there}") };
    let probes = boards.map(|serial| connected.iter().find(|probe| probe::serial(probe) == Some(serial)));
    let lacks = |serial| format!("no probe has the serial number {serial} ({there})");
    let without = boards.iter().zip(&probes).filter(|(_, probe)| probe.is_none());
    let mut missing: Vec<String> = without.map(|(serial, _)| lacks(serial)).collect();
    if port.is_none() {
        missing.push(format!("no serial port in {PORTS} has the rig's {} in its name: --port names it", boards[1]));
    }
    match (probes, port) {
        ([Some(dut), Some(rig)], Some(port)) => Ok(Found { probes: [dut.clone(), rig.clone()], port }),
        _ => Err(missing.join("; ")),
    }
}

/// The serial port behind the probe of this serial number.
fn port_of(serial: &str) -> Option<PathBuf> {
    let ports = fs::read_dir(PORTS).into_iter().flatten().flatten().map(|port| port.path());
    let of = |port: &PathBuf| port.file_name().and_then(|name| name.to_str()).is_some_and(|name| name.contains(serial));
    ports.into_iter().find(of)
}

/// The two of `DUT,RIG`.
fn two(boards: &str) -> Result<[&str; 2], Failure> {
    let serials: Vec<&str> = boards.split(',').collect();
    match serials[..] {
        [dut, rig] if !dut.is_empty() && !rig.is_empty() && dut != rig => Ok([dut, rig]),
        _ => Err(Failure::usage(format!(
            "--boards \"{boards}\" is not allowed: it must be the serial numbers of two probes, DUT,RIG (`probe-rs list` names them)"
        ))),
    }
}

/// Flashes both boards and runs the list; what came of each test is kept in tests/rig/silicon.txt, and the page is written.
fn on_a_table(given: &Options<'_>, boards: &str) -> Result<(), Failure> {
    let boards = two(boards)?;
    let key = given.value("--operator-key-file").ok_or_else(|| {
        Failure::usage("--operator-key-file FILE is needed: that which the board was given (`cargo xtask provision`)")
    })?;
    let here = env::current_dir().map_err(|cause| Failure::new(format!("no working directory: {cause}")))?;
    let port = given.value("--port").map(|port| here.join(port)).or_else(|| port_of(boards[1]));
    let found = probe::connected().and_then(|connected| find(boards, &connected, port).map_err(Failure::new));
    let openocd = setup::program("openocd", "openocd").map_or(Ok(()), |why| Err(Failure::new(why)));
    let found = match (found, openocd) {
        (Ok(found), Ok(())) => found,
        (found, openocd) => {
            plan()?;
            let missing = [found.err(), openocd.err()].into_iter().flatten().map(|why| why.to_string());
            return Err(Failure::new(missing.collect::<Vec<_>>().join("; ")));
        }
    };
    let ready = step("set-up", setup::setup)?;
    let firmware = step("image", || board::image(&ready))?;
    let rig = step("the rig's image", || image(&ready))?;
    for (probe, image) in found.probes.iter().zip([&firmware, &rig]) {
        step("flash", || {
            run(probe::probe_rs("download", Some(probe))?.arg("--verify").arg(image))?;
            run(&mut reset(probe))
        })?;
    }
    let said = |words: &[&str], program| run::output(&mut command(program, words)).map(|text| text.trim().to_owned());
    let (of, day) = (said(&["describe", "--always", "--dirty", "--tags"], "git")?, said(&["-u", "+%F"], "date")?);
    let mut runner = bench(&["run", "--bin", "rigged"], &firmware);
    let board = format!("{}:7702", given.value("--address").unwrap_or(ADDRESS));
    runner.arg("--").args(which(given));
    runner.args(["table", "--board", &board, "--image", &of, "--day", &day]);
    runner.args(["--probe", probe::serial(&found.probes[0]).unwrap_or_default()]);
    runner.arg("--key").arg(here.join(key)).arg("--port").arg(&found.port);
    runner.arg("--kept").arg(run::root().join("tests/rig/silicon.txt"));
    let ran = step("rig", || run(&mut runner));
    run(&mut rig_of(&["--", "--page"]))?;
    ran
}

/// Starts a board anew. Not with probe-rs, which ends by turning off the counter of cycles that the image has turned on.
fn reset(probe: &str) -> Command {
    let serial = format!("adapter serial {}", probe::serial(probe).unwrap_or_default());
    command("openocd", &["-f", "board/st_nucleo_h743zi.cfg", "-c", &serial, "-c", "init; reset run; shutdown"])
}

/// Which tests, and how long a soak.
fn which<'a>(given: &Options<'a>) -> Vec<&'a str> {
    let given = ["--only", "--seconds"].map(|option| given.value(option).map(|value| [option, value]));
    given.into_iter().flatten().flatten().collect()
}

/// Builds the rig's image and runs the list with the release image on one virtual board and that one on another.
pub(crate) fn on_virtual_boards(ready: &Ready, firmware: &Path, which: &[&str]) -> Result<(), Failure> {
    let image = image(ready)?;
    if Some(image.parent()) != Some(firmware.parent()) {
        return Err(Failure::new(format!("{} is not beside {}", image.display(), firmware.display())));
    }
    run(bench(&["run", "--bin", "rigged"], firmware).arg("--").args(which))
}

/// Builds the rig's image, which links only if it cannot panic, and says where it is.
pub(crate) fn image(ready: &Ready) -> Result<PathBuf, Failure> {
    run::compile(&mut build(ready, "build"))?;
    Ok(target().join(THUMB_TARGET).join("firmware/rig"))
}

/// Cargo on the rig's image: `build`, or `rustc`.
pub(crate) fn build(ready: &Ready, what: &str) -> Command {
    let mut build = ready.cargo(&[what, "--locked", "--profile", "firmware", "--package", "cohold-rig"]);
    build.args(["--bin", "rig", "--target", THUMB_TARGET]);
    build
}

#[cfg(test)]
#[path = "../tests/inside/rig.rs"]
mod tests;
