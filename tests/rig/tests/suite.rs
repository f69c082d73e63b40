//! The list against the netlist, the tests that it names, and the pages.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use cohold_rig::list::{TESTS, Wire};
use cohold_rig::{page, shown};

fn place(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(name)
}

fn text(name: &str) -> String {
    std::fs::read_to_string(place(name)).unwrap_or_else(|cause| panic!("{name}: {cause}"))
}

/// How the netlist says what a pin of the board is: its line, which has `is = "output"` and the like.
fn line_of<'a>(netlist: &'a str, pin: &str) -> &'a str {
    let begins = format!("{{ pin = \"{pin}\",");
    netlist.lines().find(|line| line.trim().starts_with(&begins)).unwrap_or_else(|| panic!("no {pin} in the netlist"))
}

#[test]
fn each_wire_ends_at_a_pin_that_takes_or_drives_what_goes_along_it() {
    let netlist = text("firmware/wiring/netlist.toml");
    for test in TESTS {
        for wire in test.wires.iter().copied().flatten() {
            let (pin, is) = match wire {
                Wire::Drives(pin) => (pin, "input"),
                Wire::Sees(pin, _) => (pin, "output"),
                Wire::Analogue(pin) | Wire::Direct(pin) => (pin, "analogue"),
                Wire::Back(..) | Wire::Button => continue,
            };
            let line = line_of(&netlist, pin);
            assert!(line.contains(&format!("is = \"{is}\"")), "{}: {wire:?}: {line}", test.name);
        }
    }
}

/// The table of the image's pins has every pin of its own that a wire ends at.
#[test]
fn each_pin_of_the_rig_is_one_that_its_image_names() {
    let image = text("tests/rig/src/image/main.rs");
    for wire in TESTS.iter().flat_map(|test| test.wires.iter().copied().flatten()) {
        let pins = match wire {
            Wire::Drives(pin) => vec![*pin],
            Wire::Sees(_, rig) => vec![*rig],
            Wire::Back(pin, rig) => vec![*pin, *rig],
            Wire::Analogue(_) | Wire::Direct(_) => vec!["PA4"],
            Wire::Button => vec!["PD14"],
        };
        for pin in pins {
            assert!(image.contains(pin), "{wire:?}: {pin}");
        }
    }
}

#[test]
fn each_test_has_a_name_of_its_own_and_what_it_names_is_there() {
    let names: BTreeSet<&str> = TESTS.iter().map(|test| test.name).collect();
    assert_eq!(names.len(), TESTS.len());
    for test in TESTS {
        assert!(test.seconds > 0 && !test.bound.is_empty(), "{}", test.name);
    }
}

#[test]
fn the_page_is_what_the_list_says() {
    let shown = shown::read(&text("tests/rig/silicon.txt")).expect("it is what was kept");
    assert!(text("docs/results/hardware.md") == page::silicon(&shown), "`cargo xtask rig --page` writes it");
}

#[test]
fn what_two_boards_have_shown_is_on_the_page() {
    let shown = shown::read("dead-man\tFAILED\t2026-12-24\tabc1234\t2100 µs").expect("a line");
    let page = page::silicon(&shown);
    let (all, others) = (TESTS.len(), TESTS.len() - 1);
    assert!(page.contains(&format!("**1 of {all} tests have run on two boards; 0 passed.**")), "{page}");
    assert!(
        page.lines()
            .any(|line| line.contains("dead-man") && line.ends_with("| **FAILED**, 2026-12-24, abc1234: 2100 µs |"))
    );
    assert_eq!(page.matches("| not yet |").count(), others);
}

#[test]
fn each_link_to_the_page_has_its_line_and_each_test_but_the_soak_a_link() {
    let page = text("docs/results/hardware.md");
    let pages = [
        "guides/board/assembly",
        "guides/board/variants",
        "guides/board/operate",
        "reference/board",
        "reference/faults",
    ];
    let pages = pages.map(|name| text(&format!("docs/{name}.md"))).concat();
    let linked: BTreeSet<&str> =
        pages.split("results/hardware.md#").skip(1).filter_map(|rest| rest.split(')').next()).collect();
    for name in &linked {
        assert!(page.contains(&format!("<a id=\"{name}\">")), "{name} has no line");
    }
    for test in TESTS.iter().filter(|test| test.name != "soak") {
        assert!(linked.contains(test.name), "nothing links to {}", test.name);
    }
}
