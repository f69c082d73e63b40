//! Text tables: aligned columns for the terminal, Markdown for the documents.
//!
//! A column whose filled cells are all numbers is set to the right, any other to the left. Widths count characters, so
//! wide scripts and combining marks are not aligned. A row that is too short is filled with empty cells, and a row that
//! is too long adds columns with an empty heading: nothing is lost and nothing fails.

use std::fmt;

/// A table of texts that prints itself with aligned columns.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TextTable {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl TextTable {
    /// A table with these column headings and no rows.
    pub fn new<S: Into<String>>(header: impl IntoIterator<Item = S>) -> Self {
        Self { header: header.into_iter().map(Into::into).collect(), rows: Vec::new() }
    }

    /// The table with one more row.
    #[must_use]
    pub fn row<S: Into<String>>(mut self, cells: impl IntoIterator<Item = S>) -> Self {
        self.push(cells);
        self
    }

    /// Adds one row.
    pub fn push<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }

    /// The table as a Markdown table, ending with a line break.
    pub fn markdown(&self) -> String {
        let escaped = Self {
            header: self.header.iter().map(|cell| escape(cell)).collect(),
            rows: self.rows.iter().map(|row| row.iter().map(|cell| escape(cell)).collect()).collect(),
        };
        let columns = escaped.columns();
        let line = |row: &[String]| format!("| {} |\n", pad(row, &columns).join(" | "));
        let rules: Vec<String> =
            columns.iter().map(|c| "-".repeat(c.width + 1) + if c.right { ":" } else { "-" }).collect();
        let rows: String = escaped.rows.iter().map(|row| line(row)).collect();
        format!("{}|{}|\n{rows}", line(&escaped.header), rules.join("|"))
    }

    fn columns(&self) -> Vec<Layout> {
        let count = self.rows.iter().map(Vec::len).fold(self.header.len(), usize::max);
        let column = |i: usize| {
            let cells = || self.rows.iter().filter_map(move |row| row.get(i));
            let width = cells().chain(self.header.get(i)).map(|c| c.chars().count()).max().unwrap_or(0);
            let filled = || cells().filter(|c| !c.is_empty());
            Layout { width, right: filled().next().is_some() && filled().all(|c| is_number(c)) }
        };
        (0..count).map(column).collect()
    }
}

impl fmt::Display for TextTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let columns = self.columns();
        writeln!(f, "{}", pad(&self.header, &columns).join("  ").trim_end())?;
        writeln!(f, "{}", columns.iter().map(|c| "-".repeat(c.width)).collect::<Vec<_>>().join("  "))?;
        for row in &self.rows {
            writeln!(f, "{}", pad(row, &columns).join("  ").trim_end())?;
        }
        Ok(())
    }
}

/// A number with at least `digits` significant digits, and never fewer than its integer part needs:
/// `significant(0.09871, 3)` is `0.0987`, `significant(10620.0, 3)` is `10620`. Below 1e-4 and from 1e9 up in
/// scientific notation.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".to_owned() } else { value.to_string() };
    }
    let after_first = digits.clamp(1, 17) - 1;
    let exponential = format!("{value:.after_first$e}");
    let exponent = exponential.split_once('e').and_then(|(_, e)| e.parse::<i32>().ok()).unwrap_or(0);
    if !(-4..9).contains(&exponent) {
        return exponential;
    }
    let decimals = usize::try_from(after_first as i32 - exponent).unwrap_or(0);
    format!("{value:.decimals$}")
}

/// How one column is set.
struct Layout {
    width: usize,
    right: bool,
}

fn pad(row: &[String], columns: &[Layout]) -> Vec<String> {
    let cell = |(i, column): (usize, &Layout)| {
        let (text, width) = (row.get(i).map_or("", String::as_str), column.width);
        if column.right { format!("{text:>width$}") } else { format!("{text:<width$}") }
    };
    columns.iter().enumerate().map(cell).collect()
}

fn is_number(cell: &str) -> bool {
    let cell = cell.trim_end_matches('%').trim().replace('−', "-");
    cell == "-" || cell == "–" || cell.parse::<f64>().is_ok()
}

fn escape(cell: &str) -> String {
    cell.replace('|', "\\|").replace('\n', "<br>")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gains() -> TextTable {
        TextTable::new(["comm", "K_T (N/m)", "note"]).row(["power", "310", ""]).row(["passive-wave", "10620.5", "a|b"])
    }

    #[test]
    fn text_is_aligned_and_numbers_are_set_right() {
        let expected = "\
comm          K_T (N/m)  note
------------  ---------  ----
power               310
passive-wave    10620.5  a|b
";
        assert_eq!(gains().to_string(), expected);
    }

    #[test]
    fn markdown_escapes_and_marks_number_columns() {
        let expected = "\
| comm         | K_T (N/m) | note |
|--------------|----------:|------|
| power        |       310 |      |
| passive-wave |   10620.5 | a\\|b |
";
        assert_eq!(gains().markdown(), expected);
    }

    #[test]
    fn ragged_and_empty_tables_lose_nothing() {
        let table = TextTable::new(["a"]).row(["1", "extra"]).row(Vec::<String>::new());
        assert!(table.to_string().contains("extra"));
        assert!(table.markdown().contains("extra"));
        assert_eq!(TextTable::default().to_string(), "\n\n");
    }

    #[test]
    fn significant_digits_keep_the_integer_part() {
        let cases = [(3.5, "3.50"), (0.09871, "0.0987"), (10620.4, "10620"), (-0.6437, "-0.644"), (0.0, "0")];
        for (value, text) in cases {
            assert_eq!(significant(value, 3), text);
        }
        assert_eq!(significant(0.99999, 3), "1.00");
        assert_eq!(significant(1.5e-7, 2), "1.5e-7");
        assert_eq!(significant(2e12, 2), "2.0e12");
        assert_eq!(significant(f64::NAN, 3), "NaN");
        assert_eq!(significant(f64::NEG_INFINITY, 0), "-inf");
    }
}
