//! What two boards on a table have shown: tests/rig/silicon.txt, a line for each test that they have run, of fields between tabs: test,
//! passed or FAILED, day, image, figures.

use std::fmt;

use crate::list::TESTS;

/// What a test on silicon came to, the last time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shown {
    /// The test's name.
    pub name: String,
    /// It was as it must be.
    pub passed: bool,
    /// The day, and which image: what `git describe` said of its sources.
    pub day: String,
    /// See [`Shown::day`].
    pub image: String,
    /// What was measured, or what went wrong.
    pub figures: String,
}

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, passed, day, image, figures } = self;
        // A field is one cell of a table, on one line.
        let figures = figures.replace(['\t', '\n', '\r'], " ").replace('|', "/");
        write!(f, "{name}\t{}\t{day}\t{image}\t{figures}", if *passed { "passed" } else { "FAILED" })
    }
}

/// What a file says.
///
/// # Errors
/// A line that is none, with its number.
pub fn read(text: &str) -> Result<Vec<Shown>, String> {
    let lines = (1..).zip(text.lines()).filter(|(_, line)| !line.is_empty());
    lines.map(|(number, line)| of(line).map_err(|why| format!("line {number}: {why}"))).collect()
}

fn of(line: &str) -> Result<Shown, String> {
    let fields: Vec<&str> = line.split('\t').collect();
    let [name, verdict, day, image, figures] = fields[..] else {
        return Err(format!("{} fields, must be 5, between tabs", fields.len()));
    };
    if !TESTS.iter().any(|test| test.name == name) {
        return Err(format!("there is no test {name}"));
    }
    let passed = match verdict {
        "passed" => true,
        "FAILED" => false,
        _ => return Err(format!("\"{verdict}\" must be passed or FAILED")),
    };
    let [day, image, figures] = [day, image, figures].map(str::to_owned);
    Ok(Shown { name: name.to_owned(), passed, day, image, figures })
}

/// The file's text with this in place of what stood there of the same test, in the list's order.
///
/// # Errors
/// As of [`read`].
pub fn with(text: &str, new: Shown) -> Result<String, String> {
    let mut all = read(text)?;
    all.retain(|old| old.name != new.name);
    all.push(new);
    all.sort_by_key(|shown| TESTS.iter().position(|test| test.name == shown.name));
    Ok(all.iter().map(|shown| format!("{shown}\n")).collect())
}

#[cfg(test)]
#[path = "../tests/inside/shown.rs"]
mod tests;
