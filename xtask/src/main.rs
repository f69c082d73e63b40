//! Chores of the project: `cargo xtask COMMAND`. One file per chore, the standard library only.
//!
//! | file | chore |
//! |---|---|
//! | [`setup`] | installs what a fresh machine lacks |
//! | [`mod@test`] | everything that must pass before a change is taken |
//! | [`mod@bench`] | measures the tick and prints the README's tables |
//! | [`instructions`] | compares instruction counts with the reviewed ones |
//! | [`board`] | runs a scene on two virtual boards |
//! | [`mod@count`] | counts instructions on the board's processor, under QEMU |
//! | [`fuzz`] | runs the protocol's fuzz targets |
//! | [`log`] | what a running board says, to a file |
//! | [`no_panic`] | shows that no panic is reachable from the tick |
//! | [`qemu`] | haptic-core on another model of the board's processor |
//! | [`provision`] | gives a board its key |
//! | [`readme`] | writes what commands print into README.md |
//! | [`rooms`] | who leans on whom: circles, imports that climb, sizes |
//! | [`run`] | how chores call other programs, and how they fail |
//!
//! Exit status: 0 when the chore succeeded, 1 when it failed, 2 when the command line is wrong.

mod bench;
mod board;
mod count;
mod fuzz;
mod instructions;
mod log;
mod no_panic;
mod provision;
mod qemu;
mod readme;
mod rooms;
mod run;
mod setup;
mod test;

use std::process::ExitCode;

const HELP: &str = "\
Chores of the project.

Usage: cargo xtask COMMAND [--help]

  setup        install what building and testing need and this machine lacks
  quick        what tells soonest whether a small change is good: format, lints, unit tests, golden traces
  test         set up, then everything that must pass: format, lints, the microcontroller build, documentation, tests
  board-test   the release image on virtual boards: same bits as the simulator, budgets, faults (builds an emulator)
  bench        measure one tick of every scene and the two-peer simulation, print the README's tables
  bench-check  compare the instructions of one tick with host-sim/cases/benches/instructions.txt
  count        count instructions on the board's processor (QEMU), compare with the reviewed tables
  board        run a scene on two virtual boards with the release image, print its table, write curves and pictures
  fuzz         run every fuzz target of the protocol for a minute, keep what it finds
  log          attach to a running board and keep what it says in out/board.log
  no-panic     show that the 1 kHz interrupt cannot panic and lies in ITCM
  provision    give a board the key that it shares with its peer and its operator, over the debug probe
  qemu         haptic-core alone on QEMU's Cortex-M7: same bits as host-sim, outputs off when it ends
  rooms        who leans on whom: circles, imports that climb, lines of every package
  readme       write what the commands named in README.md print, and the pictures they draw, into it
";

const SETUP_HELP: &str = "\
Installs what building and testing need and this machine lacks. Does nothing, in under a second, when all is there.

Usage: cargo xtask setup

  - rustfmt and clippy, with `rustup component add`
  - core for thumbv7em-none-eabihf, with `rustup target add`; where that download is refused, from Debian's sources
    with xtask/thumb-toolchain.sh

Prints the toolchain that builds for the microcontroller.
";

const TEST_HELP: &str = "\
The one command: sets up what is missing and passes every test. Stops at the first failure.

Usage: cargo xtask test

  set-up, cargo fmt --check, clippy without warnings, core and protocol built for the microcontroller, documentation
  without warnings, all tests in debug (documentation tests and what of the image needs no chip included), the golden
  traces in release as well, no panic in the tick, README.md against what its commands print, the instructions of one tick against
  host-sim/cases/benches/instructions.txt (needs valgrind, which apt-get installs if it can), the memory that interrupt and tasks
  share under loom, haptic-core on QEMU (qemu), clippy on image and bench, and the release image on virtual boards
  (board-test), whose emulator takes minutes to build.
";

const QUICK_HELP: &str = "\
What tells soonest whether a small change is good: format, lints, unit tests and golden traces, all in debug. Stops at the
first failure. Before a change is taken, `cargo xtask test` must pass.

Usage: cargo xtask quick
";

const BENCH_HELP: &str = "\
Measures one tick of every scene in every number type (instructions under callgrind, nanoseconds with criterion) and the
two-peer simulation, and prints the tables of the README in Markdown.

Usage: cargo xtask bench [--quick]

  --quick   less time for each measurement: for a look, not for the README
";

const BENCH_CHECK_HELP: &str = "\
Counts the instructions of one tick under callgrind and compares them with host-sim/cases/benches/instructions.txt: each may
differ by 2 %. x86-64 Linux only, where it installs valgrind if apt-get can.

Usage: cargo xtask bench-check [--bless]

  --bless   write what was counted to the file, for review
";

const BOARD_HELP: &str = "\
Builds the release image and runs it on two virtual NUCLEO-H743ZI2 on one wire, closed around host-sim's devices; prints
the experiment's table beside host-sim's f32 run of the same scene.

Usage: cargo xtask board [--scene FILE] [--set TABLE.KEY=VALUE]... [--seconds S] [--json] [--out DIR]

  --scene    scene file or name of a built-in one [default: paper-5.2-passive-wave-16ms]
  --set      override one key of the scene; may be repeated
  --seconds  virtual time, 1 to 3600 s [default: 20]
  --json     print one JSON document; files are written only with --out
  --out      folder for CSV and pictures [default: out/board]
";

const COUNT_HELP: &str = "\
Counts instructions on the board's processor, a Cortex-M7 under QEMU: every numerical choice of the tick, and sealing,
opening, refusing and joining on the wire. Prints the tables and compares them with the reviewed ones
(host-sim/src/studies/accuracy and protocol, instructions-cortex-m7.txt): each count may differ by 2 % or 3 instructions.

Usage: cargo xtask count [--bless]

  --bless   write what was counted to the files, for review
";

const FUZZ_HELP: &str = "\
Builds the fuzz targets of protocol/fuzz with the project's own toolchain and runs one after the other. Inputs that reach
something new are merged into protocol/fuzz/corpus; a crash leaves its input in protocol/fuzz/artifacts and fails.

Usage: cargo xtask fuzz [--seconds N] [--target NAME]

  --seconds  time for each target, 1 to 86400 s [default: 60]
  --target   one of them, as protocol/fuzz/Cargo.toml names it [default: all]
";

const LOG_HELP: &str = "\
Attaches to a running board with probe-rs, without stopping or flashing it, and prints what it says; the same goes to
out/board.log. The image must be the one that was flashed.

Usage: cargo xtask log
";

const NO_PANIC_HELP: &str = "\
Links a program that holds the 1 kHz interrupt and a panic handler that calls a function which does not exist, and has a
place for code in ITCM only: it links only if no panic is reachable and all that is lies in ITCM. Then once more with a
panic planted outside ITCM, which must fail on both counts.

Usage: cargo xtask no-panic
";

const BOARD_TEST_HELP: &str = "\
Builds the release image and the virtual board, and runs everything in tests/board: the board's bits against the
simulator's, the paper's three kinds of communications on two boards, budgets, faults. Minutes on a cold machine.

Usage: cargo xtask board-test
";

const PROVISION_HELP: &str = "\
Gives a board the key that it shares with its peer and its operator (`host-sim key generate` makes one): puts it into the flash
sector that memory.x calls KEY, over the debug probe, and starts the board anew. Flashing an image leaves it there.

Usage: cargo xtask provision --key-file FILE [--probe VID:PID[:SERIAL]]

  --key-file  the key
  --probe     which board, where two are connected (`probe-rs list` names them)
";

const QEMU_HELP: &str = "\
Builds tests/qemu, records what both peers of five built-in scenes read for 5 s (host-sim board record), and replays it on QEMU's
Cortex-M7: the hash of all that was computed must be host-sim's. Then a panic and a stack overflow there: outputs off first.
Installs qemu-system-arm if apt-get can; without it says so, and fails where CI is set.

Usage: cargo xtask qemu
";

const README_HELP: &str = "\
Runs the commands named in README.md and writes what they print, and the pictures they draw, into it and docs/.

Usage: cargo xtask readme [--check]

  --check   change nothing; fail if the text would change
";

const ROOMS_HELP: &str = "\
Prints every package's lines of Rust (src and benches, comments and tests inside files included) and who leans on whom.
Fails on files that import each other in a circle, on an import that climbs against the order in xtask/rooms.txt, and on a
package that has outgrown its lines there.

Usage: cargo xtask rooms [--root DIR]

  --root  another checkout to look at, by the same rules
";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match words.as_slice() {
        [] | ["help" | "--help" | "-h"] => print(HELP),
        ["setup", "--help" | "-h"] => print(SETUP_HELP),
        ["test", "--help" | "-h"] => print(TEST_HELP),
        ["bench", "--help" | "-h"] => print(BENCH_HELP),
        ["bench-check", "--help" | "-h"] => print(BENCH_CHECK_HELP),
        ["board", "--help" | "-h"] => print(BOARD_HELP),
        ["board", arguments @ ..] => match board::Plan::parse(arguments) {
            Ok(plan) => match board::board(&plan) {
                Ok(status) => return status,
                Err(failure) => Err(failure),
            },
            Err(failure) => {
                eprintln!("error: {failure}");
                return ExitCode::from(2);
            }
        },
        ["count", "--help" | "-h"] => print(COUNT_HELP),
        ["count"] => count::count(false),
        ["count", "--bless"] => count::count(true),
        ["fuzz", "--help" | "-h"] => print(FUZZ_HELP),
        ["fuzz", arguments @ ..] => match fuzz::Plan::parse(arguments) {
            Ok(plan) => fuzz::fuzz(plan),
            Err(failure) => {
                eprintln!("error: {failure}");
                return ExitCode::from(2);
            }
        },
        ["log", "--help" | "-h"] => print(LOG_HELP),
        ["log"] => log::log(),
        ["no-panic", "--help" | "-h"] => print(NO_PANIC_HELP),
        ["no-panic"] => setup::setup().and_then(|ready| no_panic::no_panic(&ready)),
        ["provision", "--help" | "-h"] => print(PROVISION_HELP),
        ["qemu"] => setup::setup().and_then(|ready| test::second_opinion(&ready)),
        ["qemu", "--help" | "-h"] => print(QEMU_HELP),
        ["provision", arguments @ ..] => match provision::Plan::parse(arguments) {
            Ok(plan) => provision::provision(&plan),
            Err(failure) => {
                eprintln!("error: {failure}");
                return ExitCode::from(2);
            }
        },
        ["quick", "--help" | "-h"] => print(QUICK_HELP),
        ["quick"] => test::quick(),
        ["readme", "--help" | "-h"] => print(README_HELP),
        ["readme"] => readme::readme(false),
        ["readme", "--check"] => readme::readme(true),
        ["rooms", "--help" | "-h"] => print(ROOMS_HELP),
        ["rooms"] => rooms::rooms(run::root()),
        ["rooms", "--root", other] => rooms::rooms(std::path::Path::new(other)),
        ["setup"] => setup::setup().map(|ready| println!("{}", ready.thumb_toolchain)),
        ["test"] => test::test(),
        ["board-test"] => test::board_test(),
        ["board-test", "--help" | "-h"] => print(BOARD_TEST_HELP),
        ["bench"] => bench::bench(false),
        ["bench", "--quick"] => bench::bench(true),
        ["bench-check"] => instructions::check(false),
        ["bench-check", "--bless"] => instructions::check(true),
        _ => {
            eprintln!("error: there is no `cargo xtask {}`; `cargo xtask --help` lists the commands", words.join(" "));
            return ExitCode::from(2);
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::FAILURE
        }
    }
}

fn print(help: &str) -> Result<(), run::Failure> {
    print!("{help}");
    Ok(())
}
