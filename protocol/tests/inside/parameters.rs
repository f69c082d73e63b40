//! Which table of parameters two peers differ in.

use crate::parameters::{Parameters, Table, TooManyTables};
use crate::wire::TABLES;

fn parameters(stiffness: f64, last: &'static str) -> Parameters {
    let mut all = Parameters::new();
    all.add(Table::new("timing").number("control_period_s", 0.001)).unwrap();
    all.add(Table::new("coordination").text("comm", "wave").number("stiffness_n_per_m", stiffness)).unwrap();
    all.add(Table::new(last).flag("one_sided", false)).unwrap();
    all
}

fn difference(a: &Parameters, b: &Parameters) -> Option<&'static str> {
    let (count, hashes) = b.hashes();
    a.difference(count, &hashes)
}

#[test]
fn names_the_first_table_that_differs() {
    let a = parameters(310.0, "contact");
    assert_eq!(difference(&a, &a.clone()), None);
    assert_eq!(difference(&a, &parameters(311.0, "contact")), Some("coordination"));
    assert_eq!(difference(&a, &parameters(310.0, "contacts")), Some("contact"));
}

#[test]
fn names_a_table_that_one_end_lacks() {
    let (a, mut b) = (parameters(310.0, "contact"), parameters(310.0, "contact"));
    b.add(Table::new("network")).unwrap();
    assert_eq!(difference(&a, &b), Some("a table that this peer does not have"));
    assert_eq!(difference(&b, &a), Some("network"));
    assert_eq!(difference(&Parameters::new(), &Parameters::new()), None);
}

#[test]
fn keys_in_a_row_are_the_tables_that_they_name() {
    let keys = [("timing", "a", 1.0), ("timing", "b", 2.0), ("object", "a", 3.0)];
    let mut wanted = Parameters::new();
    wanted.add(Table::new("timing").number("a", 1.0).number("b", 2.0)).unwrap();
    wanted.add(Table::new("object").number("a", 3.0)).unwrap();
    assert_eq!(Parameters::of(keys, Table::number), Ok(wanted));
    assert_eq!(Parameters::of([], Table::number), Ok(Parameters::new()));
    let turns = core::iter::repeat([("x", "a", 0.0), ("y", "a", 0.0)]).flatten();
    assert!(Parameters::of(turns.clone().take(16), Table::number).is_ok());
    assert_eq!(Parameters::of(turns.take(17), Table::number), Err(TooManyTables));
}

#[test]
fn holds_16_tables() {
    let mut all = Parameters::new();
    for _ in 0..TABLES {
        all.add(Table::new("x")).unwrap();
    }
    assert_eq!(all.add(Table::new("x")), Err(TooManyTables));
    assert_eq!(all.hashes().0, 16);
    assert_eq!(difference(&all, &all.clone()), None);
}

#[test]
fn keys_and_values_cannot_be_confused() {
    let hash = |table: Table| {
        let mut all = Parameters::new();
        all.add(table).unwrap();
        all.hashes()
    };
    assert_ne!(hash(Table::new("a").text("bc", "d")), hash(Table::new("a").text("b", "cd")));
    assert_ne!(hash(Table::new("a").flag("b", true)), hash(Table::new("a").number("b", 1.0)));
    assert_ne!(hash(Table::new("ab")), hash(Table::new("a").text("b", "")));
}
