//! The list as text and docs/silicon.md.

use std::fmt::Write;

use crate::list::{TESTS, Test, Wire};

/// What docs/silicon.md says: what has met silicon, when, with which image.
pub fn silicon() -> String {
    let mut page = String::from(
        "# Silicon: what a physical board has shown\n\n\
         **Nothing yet.** No physical board has run any image of this project. Each line below is a test for two bare NUCLEO-H743ZI2 and wires between\n\
         them, without motors: one runs the release image, the other, the rig, plays device, faults and logic analyser. The rig's image is not written\n\
         yet: the lines say what each test would do and what it must find. `cargo xtask rig --page` writes this page from\n\
         [one list](../tests/rig/src/list.rs); `cargo xtask rig` prints the wires as well. What [hardware.md](hardware.md) says beyond these lines has no line here.\n\n\
         | test | must be | as said in | nearest on the virtual board | silicon, when, image |\n|---|---|---|---|---|\n",
    );
    for Test { name, bound, from, virtual_board, .. } in TESTS {
        let tried = virtual_board
            .map_or_else(|| "nothing near".to_owned(), |file| format!("[{file}](../tests/board/tests/boards/{file})"));
        // A String takes all that is written.
        let _ = writeln!(page, "| <a id=\"{name}\"></a>{name} | {bound} | {from} | {tried} | not yet |");
    }
    page
}

/// What each test would do, for a terminal.
pub fn plan() -> String {
    let mut plan = String::from(
        "Nothing was run: the rig's image is not written yet. With it and two NUCLEO-H743ZI2, their grounds joined (CN8-11), each test would do this.\n",
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
        Wire::Sees(pin) => format!("{pin} > rig {pin}"),
        Wire::Analogue(pin) => format!("rig PA5 > {pin}"),
    }
}
