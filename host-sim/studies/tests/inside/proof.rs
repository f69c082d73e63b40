//! The page of the laws has the proof of every law there is.

use super::*;
use crate::campaign::laws::page::{PROOFS, between, with};

const PAGE: &str = include_str!("../../../../docs/results/laws.md");

/// A row a law in the registry's order, each with its verdict: a law that was added is missing until `cohold stability prove --page docs/results/laws.md` was run.
#[test]
fn every_law_stands_proved_in_the_page() {
    let found = between(PAGE, PROOFS).expect("a section of proofs");
    let rule = found.lines().position(|line| line.starts_with("---")).expect("a table");
    let rows = found.lines().skip(rule + 1).take_while(|line| !line.is_empty());
    let verdicts: Vec<(&str, bool)> =
        rows.map(|row| (row.split("  ").next().unwrap_or(row), row.ends_with("  holds"))).collect();
    let wanted: Vec<(&str, bool)> = names(cohold_guest_laws::laws()).into_iter().map(|name| (name, true)).collect();
    assert_eq!(verdicts, wanted, "cohold stability prove --page docs/results/laws.md");
    // The words around the table are those of the code.
    let empty = section(&report(&columns(&[])));
    let marks = ["law", "(any law)"].map(|mark| empty.find(&format!("\n{mark}")).expect("words"));
    assert!(found.starts_with(&empty[..marks[0]]) && found.ends_with(&empty[marks[1]..]), "{found}");
}

/// Only what is between the lines is written, and nothing into a page that has none.
#[test]
fn a_section_is_written_between_its_lines() {
    let page = format!("before\n{}\nold\n{}\nafter\n", PROOFS[0], PROOFS[1]);
    let fresh = with(&page, PROOFS, "new\n").expect("lines");
    assert_eq!(fresh, page.replace("old", "new"));
    assert_eq!(between(&fresh, PROOFS), Some("new"));
    assert_eq!(with("no lines", PROOFS, "new"), None);
}
