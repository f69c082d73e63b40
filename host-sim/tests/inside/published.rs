//! Every law has a number of its paper; every number is met, or why not is reported.

use std::sync::LazyLock;

use super::*;

/// How near is near enough, relative.
const WITHIN: f64 = 0.05;

static ROWS: LazyLock<Vec<Row>> = LazyLock::new(|| rows().expect("measurements"));

/// A law that is added is missing here until its paper has a row.
#[test]
fn every_law_has_a_number_of_its_paper() {
    let of = |name: &str| NUMBERS.iter().filter(|number| number.law == name).count();
    let laws = cohold_guest_laws::laws();
    let missing: Vec<&str> = laws.all().iter().map(|law| law.name).filter(|name| of(name) == 0).collect();
    assert!(missing.is_empty(), "no number of the paper of {missing:?} in NUMBERS");
    let known = laws.all().iter().map(|law| of(law.name)).sum::<usize>();
    assert_eq!(known, NUMBERS.len(), "a number of a law that is not in the registry");
}

#[test]
fn every_number_is_met_or_told_why_not() {
    let told = |row: &Row| {
        let Row { number, theirs, ours } = row;
        format!("{}, {}: {ours} {}, the paper's {theirs}; why: {:?}", number.law, number.what, number.unit, number.why)
    };
    let open: Vec<String> =
        ROWS.iter().filter(|row| (row.off().abs() <= WITHIN) != row.number.why.is_empty()).map(told).collect();
    assert!(open.is_empty(), "{open:#?}");
}

/// A number of a paper says where it stands there; what we worked out ourselves is never called printed.
#[test]
fn what_is_printed_says_where() {
    for number in NUMBERS.iter().filter(|number| number.says == Printed) {
        let place = number.place;
        assert!(["§", "Fig.", "abstract", ">"].iter().any(|mark| place.contains(mark)), "{}: {place}", number.law);
        assert!(!number.paper.contains("docs/"), "{}: {}", number.law, number.paper);
    }
    let table = columns(&ROWS);
    let said = |word: &str| (0..table.len()).filter(|at| table.row(*at)["says"] == word).count();
    assert_eq!((said("printed"), said("algebra of ours")), (8, 17));
    assert_eq!(table.len(), 8 + 17);
}

/// Printed by the papers themselves, of at least three of them, to 5 %.
#[test]
fn three_papers_print_what_is_measured() {
    let mut papers: Vec<&str> = ROWS
        .iter()
        .filter(|row| row.number.says == Printed && row.off().abs() <= WITHIN)
        .map(|row| row.number.paper)
        .collect();
    papers.sort_unstable();
    papers.dedup();
    assert!(papers.len() >= 3, "{papers:?}");
}
