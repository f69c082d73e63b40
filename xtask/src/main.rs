//! Chores of the project: `cargo xtask COMMAND`. One file per chore, the standard library only.
//!
//! Exit status: 0 when the chore succeeded, 1 when it failed, 2 when the command line is wrong.

mod bench;
mod board;
mod builds;
mod count;
mod drawings;
mod fuzz;
mod homes;
mod kept;
mod lerobot;
mod licences;
mod lines;
mod no_panic;
mod options;
mod packages;
mod page;
mod platforms;
mod probe;
mod python;
mod qemu;
mod readme;
mod recordings;
mod release;
mod rig;
mod rooms;
mod run;
mod setup;
mod test;

use std::process::ExitCode;

use options::Options;
use run::Failure;

struct Chore {
    name: &'static str,
    /// What may follow it.
    options: &'static str,
    /// One sentence of what it does.
    does: &'static str,
    /// The rest of its help.
    more: &'static str,
    run: fn(&Options<'_>) -> Result<(), Failure>,
}

const CHORES: [Chore; 19] = [
    Chore {
        name: "quick",
        options: "",
        does: "Tells soonest whether a small change is good: format, lints, unit tests, golden traces, all in debug",
        more: "Stops at the first failure. Before a change is taken, `cargo xtask test` must pass.",
        run: |_| test::quick(),
    },
    Chore {
        name: "test",
        options: " [--anew] [--lane LANE] [--only STEP]",
        does: "The one command: sets up what is missing and passes every test",
        more: "Two lanes run side by side. A step that passed on this machine with the same content does not run again. The first failure stops
both lanes. At a terminal the check asks before apt-get installs a package. At the end it prints what each step took.
`boards` proves with the linker that the 1 kHz interrupt cannot panic and lies in ITCM, and runs every image on virtual boards and
cohold-core on QEMU's processor; then come the first build, pages, golden traces, tables and instructions. `rest` is everything
else: tests of a PC in debug with Clippy as the compiler, other platforms, recordings, the Python module, packages, two homes.
  --anew  run every step, whatever passed before
  --lane  run one lane alone: boards or rest
  --only  run one step alone, whatever passed before; a wrong name prints all of them",
        run: test::test,
    },
    Chore {
        name: "bench",
        options: " [--quick]",
        does: "Measures one tick of every scene and the two-peer simulation, prints the tables of docs/ in Markdown",
        more: "Instructions under callgrind, nanoseconds with criterion, in every number type.
  --quick   less time for each measurement: for a look, not for a page",
        run: |given| bench::bench(given.flag("--quick")),
    },
    Chore {
        name: "bench-check",
        options: " [--bless]",
        does: "Counts the instructions of one tick and compares them with host-sim/cases/benches/instructions.txt",
        more: "Under callgrind; each may differ by 2 %. x86-64 Linux only, where it installs valgrind if apt-get can.
  --bless   write what was counted to the file, for review",
        run: |given| count::ticks(given.flag("--bless")),
    },
    Chore {
        name: "count",
        options: " [--bless]",
        does: "Counts instructions on the board's processor, a Cortex-M7 under QEMU, and compares with the reviewed tables",
        more: "Every numerical choice of the tick (host-sim/studies/src/accuracy), and sealing, opening, refusing and joining on the
wire (protocol): instructions-cortex-m7.txt in each. Each count may differ by 2 % or 3 instructions.
  --bless   write what was counted to the files, for review",
        run: |given| count::board(given.flag("--bless")),
    },
    Chore {
        name: "board",
        options: " [--scene FILE] [--set TABLE.KEY=VALUE]... [--seconds S] [--json] [--out DIR]",
        does: "Runs a scene on two virtual boards with the release image, prints its table, writes curves and pictures",
        more: "Two NUCLEO-H743ZI2 on one wire, closed around cohold's devices, beside cohold's f32 run of the same scene.
  --scene    scene file or name of a built-in one [default: paper-5.2-passive-wave-16ms]
  --set      override one key of the scene; may be repeated
  --seconds  virtual time, 1 to 3600 s [default: 20]
  --json     print one JSON document; files are written only with --out
  --out      folder for CSV and pictures [default: out/board]",
        run: board::board,
    },
    Chore {
        name: "drawings",
        options: " [--check]",
        does: "Draws the sheets of docs/guides/board/assembly.md from the board's netlist, and writes that page's tables",
        more: "From firmware/wiring/netlist.toml, which must break none of the rules in firmware/wiring/src/rules.rs.
  --check   change nothing; fail if a drawing or a table would change",
        run: |given| drawings::drawings(given.flag("--check")),
    },
    Chore {
        name: "fuzz",
        options: " [--seconds N] [--target NAME]",
        does: "Runs every fuzz target of wire, roles, files and page for a minute, keeps what it finds",
        more: "Built with the project's own toolchain, one after the other. Inputs that reach something new are merged into
corpus/ of protocol/fuzz or host-sim/{environments/,live/,}fuzz; a crash leaves its input in artifacts/ beside it and fails.
  --seconds  time for each target, 1 to 86400 s [default: 60]
  --target   one of them, as Cargo.toml in either folder names it [default: all]",
        run: fuzz::fuzz,
    },
    Chore {
        name: "log",
        options: " [--probe VID:PID[:SERIAL]]",
        does: "Attaches to a running board and adds what it says to out/board.log",
        more: "With probe-rs, without flashing it. The image must be the one that was flashed. Disarm first: probe-rs halts the
processor for a moment when it attaches and when it ends, which turns an armed board's motors off (fault 72).
  --probe  which board, where two are connected (`probe-rs list` names them)",
        run: probe::log,
    },
    Chore {
        name: "page",
        options: " [--write] [--measure] [--seconds S]",
        does: "Checks the sources of cohold play's page: types, lints, format; or measures it in a browser",
        more: "TypeScript and Biome, in the versions and with the hashes of tests/page/package-lock.json. Installs npm if apt-get can.
  --write    write the format, and mend what can be mended without thought
  --measure  print instead, for the release build without windows and with two in Chromium, how many ticks were late, and
             how long it takes from a moved pointer to its picture
  --seconds  for how long each, 10 to 3600 s [default: 60]",
        run: |given| match given.flag("--measure") {
            true => page::measure(given.value("--seconds").unwrap_or("60")),
            false => page::page(given.flag("--write")),
        },
    },
    Chore {
        name: "provision",
        options: " --key-file FILE --operator-key-file FILE [--probe VID:PID[:SERIAL]]",
        does: "Gives a board its two keys over the debug probe: the one it shares with its peer, and its operator's",
        more: "Puts the keys into the flash sector that memory.x calls KEY and starts the board anew. Flashing an image leaves them
there. Two files with one key are refused: who holds the peers' could arm the board.
  --key-file           the peers' key, or that of the board's line to a hub (`cohold key generate`)
  --operator-key-file  the operator's key (`cohold key generate --operator`)
  --probe              which board, where two are connected (`probe-rs list` names them)",
        run: probe::provision,
    },
    Chore {
        name: "python",
        options: "",
        does: "Builds and installs the Python module, and compares what it gives with the command line's word",
        more: "The tests in host-sim/python/tests: every bit, errors, sweeps on two processes of which one is killed, examples, and every
table of the program read by pandas and Arrow. The versions of host-sim/python/requirements.txt are installed into a virtual environment
below target/ when they have changed; it needs Python 3.11 with venv and, then, the registry. LeRobot's own loops with the packages in
host-sim/python/lerobot likewise, in the versions of its requirements.txt; they need Python 3.12 or 3.13 (pyenv's, too).",
        run: |_| python::python(),
    },
    Chore {
        name: "verdicts",
        options: " [--scenes N] [--seed S] [--limits]",
        does: "Compares verdicts of the analyser with kicked runs of random scenes, and writes their table for review",
        more: "10,000 scenes of all laws in every mode, as a release: an hour on two cores. Writes host-sim/analysis/tests/verdicts.txt. Fails if a scene
that is called stable grows.
  --scenes  how many [default: 10000]
  --seed    number of the first scene; other than 0, and no file is written [default: 0]
  --limits  find instead the stiffest contact of any-network at 0 to 250 ms, and write host-sim/analysis/tests/limits.csv",
        run: test::verdicts,
    },
    Chore {
        name: "rig",
        options: " [--page] [--virtual] [--boards DUT,RIG --operator-key-file FILE] [--address ADDRESS] [--port PATH] [--only TEST] [--seconds S]",
        does: "Says what two bare boards and wires between them are to show on silicon, or runs it on them or on two virtual ones",
        more: "One NUCLEO-H743ZI2 runs the release image, the other plays device, faults and logic analyser: wires, what is driven,
what is measured, and what it must be. The runner is that of the virtual boards; the first time it builds an emulator.
  --page               write docs/results/hardware.md: which tests physical boards have passed, when, with which image
  --virtual            run both images on virtual boards, wired pin to pin, and each test that these can
  --boards             run it on two boards, by the serial numbers of their probes (`probe-rs list`): that under test, which has its keys
                       (provision), and the rig. Both are flashed; what came of each test is kept in tests/rig/silicon.txt, and the page
                       written. Needs probe-rs and OpenOCD, which apt-get installs if it can
  --operator-key-file  the operator's key of the board under test
  --address            its address [default: 192.168.77.1]
  --port               the rig's serial port [default: that of its probe in /dev/serial/by-id]
  --only               one test alone
  --seconds            how long the soak takes, 1 to 604800 s [default: 86400; on virtual boards 5]",
        run: rig::rig,
    },
    Chore {
        name: "rooms",
        options: " [--bless]",
        does: "Checks size and dependencies of each package, and what cargo compiles, against ceilings that only fall",
        more: "Lines are code as rustfmt sets it, 100 wide, without comments and blank lines. Nothing is built. Fails if a row of
xtask/ceilings.txt is above its ceiling or 3 % below, if the ceilings of a group sum to more than in an earlier commit, if a package
does not lean on what its row says, or if one of the heart newly leans on a guest. A row may rise when others of its group fall.
  --bless   lower each ceiling that is 3 % too high, and raise none",
        run: |given| rooms::rooms(&test::calls(&setup::setup()?), given.flag("--bless")),
    },
    Chore {
        name: "readme",
        options: " [--check] [--page FILE]",
        does: "Writes what the commands named in README.md and docs/ print, and the pictures they draw, into them",
        more: "  --check   change nothing; fail if a text would change
  --page    this one only: README.md, docs/results/accuracy.md",
        run: |given| readme::readme(given.flag("--check"), given.value("--page")),
    },
    Chore {
        name: "site",
        options: "",
        does: "Builds the documentation in docs/ as a site with a search, in target/site",
        more: "With mdBook, which it installs below target/. Links are checked by `cargo xtask test`.",
        run: |_| readme::site(),
    },
    Chore {
        name: "release",
        options: " [--tag TAG] [--out DIR]",
        does: "Builds a tag as files to give away: images, command line, wheel, sources, what is in them, and sums",
        more: "From a clone of the tag: the boards' images, one for each feature, without this machine's paths (the same toolchain makes the same bytes anywhere),
cohold, on x86-64 once more for AVX2 and for AVX-512, and on Linux for glibc 2.17 and later, the Python module as wheel and sources, the crates, a list of all packages and licences (CycloneDX, by cargo-cyclonedx,
which is installed below target/), what built them, and SHA-256 sums. Nothing is uploaded. The tag is `v` and the version in Cargo.toml.
`cargo xtask test` in that clone says whether it is fit to be given away.
  --tag  which tag [default: that of what is checked out]
  --out  folder, in which a folder of the tag's name is made [default: out/release]",
        run: release::release,
    },
    Chore {
        name: "wheel",
        options: " [--out DIR]",
        does: "Builds the Python module as a wheel for CPython 3.11 and later",
        more: "With maturin, from host-sim/python, for this machine's system and processor; on Linux linked by zig, for glibc 2.17 and later. `pip install .`
builds the same for this machine.
  --out  folder [default: out/wheel]",
        run: |given| {
            let folder = run::root().join(given.value("--out").unwrap_or("out/wheel"));
            python::wheel(run::root(), &folder, "release").map(|wheel| println!("{}", wheel.display()))
        },
    },
];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let chore = words.first().and_then(|word| CHORES.iter().find(|chore| chore.name == *word));
    let outcome = match (chore, words.as_slice()) {
        (None, [] | ["help" | "--help" | "-h"]) => {
            println!("Chores of the project.\n\nUsage: cargo xtask COMMAND [--help]\n");
            CHORES.iter().for_each(|Chore { name, does, .. }| println!("  {name:<12} {does}"));
            Ok(())
        }
        (Some(Chore { name, options, does, more, .. }), [_, "--help" | "-h"]) => {
            println!("{does}.\n\nUsage: cargo xtask {name}{options}\n\n{more}");
            Ok(())
        }
        (Some(chore), [_, rest @ ..]) => {
            Options::read(chore.name, chore.options, rest).and_then(|given| (chore.run)(&given))
        }
        _ => Err(Failure::usage(format!(
            "there is no `cargo xtask {}`; `cargo xtask --help` lists the commands",
            words.join(" ")
        ))),
    };
    outcome.map_or_else(Failure::report, |()| ExitCode::SUCCESS)
}

#[cfg(test)]
fn read<'a>(name: &str, words: &[&'a str]) -> Result<Options<'a>, Failure> {
    let chore = CHORES.iter().find(|chore| chore.name == name).unwrap();
    Options::read(name, chore.options, words)
}
