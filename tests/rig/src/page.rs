//! The list as text and docs/results/hardware.md.

use std::fmt::Write;

use crate::list::{TESTS, Test, Virtual, Wire};
use crate::shown::Shown;

/// What docs/results/hardware.md reports: which tests physical boards have passed, when, with which image.
pub fn silicon(shown: &[Shown]) -> String {
    let passed = shown.iter().filter(|shown| shown.passed).count();
    let met = match shown.len() {
        0 => "**Nothing yet.** No physical board has run any image of this project.".to_owned(),
        run => format!("**{run} of {} tests have run on two boards; {passed} passed.**", TESTS.len()),
    };
    let mut page = format!(
        "# Shown on silicon\n\n\
         {met}\n\n\
         Each line is a statement about the [board](../reference/board.md) that two bare NUCLEO-H743ZI2 can test, without motors.\n\
         One board runs the released firmware. The other plays its encoder, its faults and its stop, and measures the answer.\n\n\
         ```sh\n\
         cargo xtask rig                    # what each test does, and its wires\n\
         cargo xtask rig --virtual          # on two virtual boards\n\
         cargo xtask rig --boards DUT,RIG   # on two boards, by their probes\n\
         ```\n\n\
         `current-sensor-ends` and `sample-after-edge` need other wires at PA3 and PB1, so they run only with `--only`.\n\n\
         **Limits.** A virtual board executes the released firmware, but its chip is a model. Its times count instructions, and its\n\
         electrical behaviour comes from data sheets. A statement without a line here cannot be tested this way. No test includes a\n\
         motor, or a hand at a device.\n\n\
         | Test | Question | Passes if | On virtual boards | On two boards |\n|---|---|---|---|---|\n",
    );
    for Test { name, question, bound, virtual_rig, .. } in TESTS {
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
        let _ = writeln!(page, "| <a id=\"{name}\"></a>{name} | {question} | {bound} | {virtually} | {met} |");
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
        let Test { name, drives, measures, question, bound, seconds, .. } = test;
        let wires: Vec<String> = test.wires.concat().iter().map(wire).collect();
        let wires = if wires.is_empty() { "none".to_owned() } else { wires.join(", ") };
        let _ = write!(
            plan,
            "\n{name}, {seconds} s: {question}\n  wires     {wires}\n  drives    {drives}\n  measures  {measures}\n  passes if {bound}\n"
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
