//! Text tables: aligned columns for the terminal, Markdown for the documents.
//!
//! A column whose filled cells are all numbers is set to the right, any other to the left. Widths count characters, so
//! wide scripts and combining marks are not aligned. A row that is too short is filled with empty cells, and a row that
//! is too long adds columns with an empty heading: nothing is lost and nothing fails.

use std::fmt;

pub use haptic_plot::significant;

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
}
