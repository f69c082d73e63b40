//! The reviewed budgets (`budgets.txt`) and what was measured: what is over its budget fails the build.

use std::io::Write;

const BUDGETS: &str = include_str!("../budgets.txt");
/// How far a count that is stated as it was may be off, either way.
const TOLERANCE: f64 = 0.02;

/// What a budget says.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rule {
    /// The number may not be more than this.
    AtMost(f64),
    /// This, to within [`TOLERANCE`]: less is for review too.
    About(f64),
}

fn rule(name: &str) -> Option<Rule> {
    let line = BUDGETS.lines().find(|line| line.split_whitespace().next() == Some(name))?;
    let mut words = line.split_whitespace().skip(1);
    let (sign, value) = (words.next()?, words.next()?.parse().ok()?);
    match sign {
        "<=" => Some(Rule::AtMost(value)),
        "~" => Some(Rule::About(value)),
        _ => None,
    }
}

/// Measured values, by the names of the budgets.
#[derive(Debug, Default)]
pub struct Measured(Vec<(String, f64)>);

impl Measured {
    /// Adds a measured number.
    pub fn add(&mut self, name: impl Into<String>, value: impl Into<f64>) {
        self.0.push((name.into(), value.into()));
    }

    /// What was measured under a name.
    ///
    /// # Panics
    /// Nothing was.
    pub fn of(&self, name: &str) -> f64 {
        self.0.iter().find(|(known, _)| known == name).unwrap_or_else(|| panic!("{name} was not measured")).1
    }

    /// Prints all, and fails on what is over.
    ///
    /// # Panics
    /// Something is over its budget or has none.
    pub fn check(&self) {
        let mut over = Vec::new();
        for (name, value) in &self.0 {
            let rule = rule(name);
            let within = match rule {
                Some(Rule::AtMost(most)) => *value <= most,
                Some(Rule::About(expected)) => (value - expected).abs() <= TOLERANCE * expected,
                None => false,
            };
            let rule = rule.map_or("no budget".to_owned(), |rule| format!("{rule:?}"));
            // Not println!, which the test harness keeps to itself while all is well: CI is to show the sizes.
            let _ = writeln!(std::io::stdout(), "{name:<44} {value:>9}   {rule}");
            if !within {
                over.push(name.as_str());
            }
        }
        assert!(over.is_empty(), "not as tests/board/budgets.txt says (see above): {}", over.join(", "));
    }
}
