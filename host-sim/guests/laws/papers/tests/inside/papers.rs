//! Every law has a number of its paper or its equation; every number is met, or why not is reported.

use std::sync::LazyLock;

use super::*;

#[path = "equations.rs"]
mod equations;

use equations::EQUATIONS;

/// How near is near enough, relative.
const WITHIN: f64 = 0.05;

static ROWS: LazyLock<Vec<Row>> = LazyLock::new(|| rows().expect("measurements"));

/// A law that is added is missing here until its paper has a row.
#[test]
fn every_law_has_a_number_of_its_paper() {
    let known: Vec<&str> = NUMBERS.iter().map(|number| number.law).chain(EQUATIONS.iter().map(|row| row.0)).collect();
    let laws = cohold_guest_laws::laws();
    let names: Vec<&str> = laws.all().iter().map(|law| law.name).collect();
    let missing: Vec<_> = names.iter().filter(|name| !known.contains(name)).collect();
    let strange: Vec<_> = known.iter().filter(|name| !names.contains(name)).collect();
    assert!(missing.is_empty() && strange.is_empty(), "no number of {missing:?}, no law of {strange:?}");
}

#[test]
fn every_number_is_met_or_told_why_not() {
    let told = |row: &Row| {
        let Row { number, ours } = row;
        let Number { law, what, unit, theirs, why, .. } = number;
        format!("{law}, {what}: {ours} {unit}, the paper's {theirs}; why: {why:?}")
    };
    let open: Vec<String> =
        ROWS.iter().filter(|row| (row.off().abs() <= WITHIN) != row.number.why.is_empty()).map(told).collect();
    assert!(open.is_empty(), "{open:#?}");
}

/// A number of a paper says where it stands there.
#[test]
fn what_is_printed_says_where() {
    for Number { law, paper, place, .. } in NUMBERS {
        assert!(["§", "Fig.", "abstract", ">"].iter().any(|mark| place.contains(mark)), "{law}: {place}");
        assert!(!paper.contains("docs/"), "{law}: {paper}");
    }
    assert_eq!(columns(&ROWS).len(), 8);
}

/// Of at least three papers a number is met to 5 %.
#[test]
fn three_papers_print_what_is_measured() {
    let mut papers: Vec<&str> =
        ROWS.iter().filter(|row| row.off().abs() <= WITHIN).map(|row| row.number.paper).collect();
    papers.sort_unstable();
    papers.dedup();
    assert!(papers.len() >= 3, "{papers:?}");
}
