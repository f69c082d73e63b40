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
mod tests {
    use super::*;

    fn shown(name: &str, passed: bool, figures: &str) -> Shown {
        let [name, day, image, figures] = [name, "2026-11-25", "v0.3-4-gabc", figures].map(str::to_owned);
        Shown { name, passed, day, image, figures }
    }

    #[test]
    fn a_test_has_one_line_and_the_last_word_is_what_stands_there() {
        let text = with("", shown("soak", true, "a | b\nc")).unwrap();
        assert_eq!(text, "soak\tpassed\t2026-11-25\tv0.3-4-gabc\ta / b c\n");
        let text = with(&text, shown("dead-man", false, "2100 µs")).unwrap();
        let text = with(&text, shown("soak", false, "one fault")).unwrap();
        let told = read(&text).unwrap();
        assert_eq!(told, [shown("dead-man", false, "2100 µs"), shown("soak", false, "one fault")]);
    }

    #[test]
    fn a_line_that_is_none_is_refused_by_its_number() {
        for (text, why) in [
            ("\nsoak passed\n", "line 2: 1 fields, must be 5, between tabs"),
            ("soke\tpassed\td\ti\tf", "line 1: there is no test soke"),
            ("soak\tok\td\ti\tf", "line 1: \"ok\" must be passed or FAILED"),
        ] {
            assert_eq!(read(text).unwrap_err(), why);
        }
    }
}
