//! The list as text and docs/silicon.md.

use std::fmt::Write;

use crate::list::{TESTS, Test, Virtual, Wire};

/// What docs/silicon.md says: what has met silicon, when, with which image.
pub fn silicon() -> String {
    let mut page = String::from(
        "# Silicon: what a physical board has shown\n\n\
         **Nothing yet.** No physical board has run any image of this project. Each line below is a test for two bare NUCLEO-H743ZI2 and wires between\n\
         them, without motors: one runs the release image, the other, the rig, plays device, faults and logic analyser with\n\
         [an image of its own](../tests/rig/src/image/main.rs). `cargo xtask rig --virtual` runs both images on virtual boards, wired pin to pin; what runs on two\n\
         boards on a table, with a probe and a serial port, is not written yet. `cargo xtask rig --page` writes this page from\n\
         [one list](../tests/rig/src/list.rs); `cargo xtask rig` prints the wires as well. What [hardware.md](hardware.md) says beyond these lines has no line here.\n\n\
         | test | must be | as said in | the rig's image on virtual boards | nearest without it | silicon, when, image |\n|---|---|---|---|---|---|\n",
    );
    for Test { name, bound, from, virtual_board, virtual_rig, .. } in TESTS {
        let tried = virtual_board
            .map_or_else(|| "nothing near".to_owned(), |file| format!("[{file}](../tests/board/tests/boards/{file})"));
        let virtually = match virtual_rig {
            Virtual::Runs(extent) => format!("passes: {extent}"),
            Virtual::Not(reason) => format!("not run: {reason}"),
        };
        // A String takes all that is written.
        let _ = writeln!(page, "| <a id=\"{name}\"></a>{name} | {bound} | {from} | {virtually} | {tried} | not yet |");
    }
    page
}

/// What each test would do, for a terminal.
pub fn plan() -> String {
    let mut plan = String::from(
        "Nothing was run: `cargo xtask rig --virtual` runs what two virtual boards can. With two NUCLEO-H743ZI2, their grounds joined (CN8-11), each test would do this.\n",
    );
    for test in TESTS {
        let Test { name, drives, measures, bound, from, seconds, .. } = test;
        let wires = if test.wires.is_empty() {
            "none".to_owned()
        } else {
            test.wires.iter().map(wire).collect::<Vec<_>>().join(", ")
        };
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
        Wire::Analogue(pin) => format!("rig PA4 > {pin}"),
        Wire::Button => "rig PD14 > PC13".to_owned(),
    }
}
