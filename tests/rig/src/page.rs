//! The list as text and docs/silicon.md.

use std::fmt::Write;

use crate::list::{TESTS, Test, Virtual, Wire};
use crate::shown::Shown;

/// What docs/silicon.md says: what has met silicon, when, with which image.
pub fn silicon(shown: &[Shown]) -> String {
    let passed = shown.iter().filter(|shown| shown.passed).count();
    let met = match shown.len() {
        0 => "**Nothing yet.** No physical board has run any image of this project.".to_owned(),
        run => format!("**{run} of {} tests have run on two boards; {passed} passed.**", TESTS.len()),
    };
    let mut page = format!(
        "# Silicon: what a physical board has shown\n\n\
         {met} Each line below is a test for two bare NUCLEO-H743ZI2 and wires between\n\
         them, without motors: one runs the release image, the other, the rig, plays device, faults and logic analyser with\n\
         [an image of its own](../tests/rig/src/image/main.rs). `cargo xtask rig` prints the wires, and says how two boards on a table run the list (`--boards`): it\n\
         flashes both, runs each test and keeps what came of it in [tests/rig/silicon.txt](../tests/rig/silicon.txt), from which and from\n\
         [one list](../tests/rig/src/list.rs) `cargo xtask rig --page` writes this page. `cargo xtask rig --virtual` runs both images on virtual boards, wired pin to pin; the way to\n\
         a table, serial port and sockets, carried one of the tests with these behind it ([table.rs](../tests/board/tests/boards/table.rs)); probe-rs and OpenOCD had no probe.\n\
         `current-sensor-ends` and `sample-after-edge` have other wires at PA3 and PB1. On a table they run only if `--only` names them.\n\
         What [hardware.md](hardware.md) says beyond these lines has no line here.\n\n\
         | test | must be | as said in | the rig's image on virtual boards | nearest without it | silicon, when, image |\n|---|---|---|---|---|---|\n",
    );
    for Test { name, bound, from, virtual_board, virtual_rig, .. } in TESTS {
        let tried = virtual_board
            .map_or_else(|| "nothing near".to_owned(), |file| format!("[{file}](../tests/board/tests/boards/{file})"));
        let virtually = match virtual_rig {
            Virtual::Runs(extent) => format!("passes: {extent}"),
            Virtual::Not(reason) => format!("not run: {reason}"),
        };
        let met = shown.iter().find(|shown| shown.name == name);
        let met = met.map_or("not yet".to_owned(), |shown| {
            let verdict = if shown.passed { "passed" } else { "**FAILED**" };
            format!("{verdict}, {}, {}: {}", shown.day, shown.image, shown.figures)
        });
        // A String takes all that is written.
        let _ = writeln!(page, "| <a id=\"{name}\"></a>{name} | {bound} | {from} | {virtually} | {tried} | {met} |");
    }
    page
}

/// What each test would do, for a terminal.
pub fn plan() -> String {
    let mut plan = String::from(
        "Nothing was run: `cargo xtask rig --virtual` runs what two virtual boards can. With two NUCLEO-H743ZI2, their grounds joined (CN8-11), \
         `cargo xtask rig --boards DUT,RIG` would do this.\n",
    );
    for test in TESTS {
        let Test { name, drives, measures, bound, from, seconds, .. } = test;
        let wires: Vec<String> = test.wires.concat().iter().map(wire).collect();
        let wires = if wires.is_empty() { "none".to_owned() } else { wires.join(", ") };
        let _ = write!(
            plan,
            "\n{name}, {seconds} s\n  wires     {wires}\n  drives    {drives}\n  measures  {measures}\n  must be   {bound} ({from})\n"
        );
    }
    plan
}

/// A wire, from who drives it.
fn wire(wire: &Wire) -> String {
    match wire {
        Wire::Drives(pin) => format!("rig {pin} > {pin}"),
        Wire::Sees(pin, rig) => format!("{pin} > rig {rig}"),
        Wire::Back(pin, rig) => format!("rig {pin} > rig {rig}"),
        Wire::Analogue(pin) => format!("rig PA4 > 10 kΩ > {pin}, 10 µF to ground"),
        Wire::Direct(pin) => format!("rig PA4 > {pin}"),
        Wire::Button => "rig PD14 > PC13".to_owned(),
    }
}
