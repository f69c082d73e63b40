//! Columns: what a table holds, declared once, as aligned text, CSV, Parquet and JSON.
//!
//! A study declares its columns over a slice of its rows; name, digits and meaning stand in one place:
//!
//! ```
//! use cohold_columns::Columns;
//! struct Cell { comm: &'static str, stable: bool, true_discrepancy_mm: f64, mass_kg: Option<f64> }
//! let cells = [Cell { comm: "power", stable: true, true_discrepancy_mm: 3.2407, mass_kg: None }];
//! let columns = Columns::of(&cells)
//!     .value("comm", |cell| cell.comm).means("how the copies are held together")
//!     .value("stable", |cell| cell.stable).means("nobody stopped, nothing grew")
//!     .number("true_discrepancy_mm", 2, |cell| cell.true_discrepancy_mm).head("true").means("|x_o1 - x_o2|")
//!     .number("mass_kg", 3, |cell| cell.mass_kg).means("what the hands feel")
//!     .done();
//! assert_eq!(columns.to_string(), "\
//! comm   stable  true mm  mass kg
//! -----  ------  -------  -------
//! power  yes        3.24        -
//! ");
//! assert_eq!(
//!     serde_json::to_string(&columns)?,
//!     r#"[{"comm":"power","stable":true,"true_discrepancy_mm":3.2407,"mass_kg":null}]"#
//! );
//! # Ok::<(), serde_json::Error>(())
//! ```
//!
//! The **name** is the field of JSON, the heading of CSV and the column of Parquet; it ends with the unit
//! (`true_discrepancy_mm`), or that of the parts between its dots does which is the last to have one. A dot nests in JSON
//! (`force_n.mean`, `energy.0.sent_j`), as pandas' `json_normalize` undoes it. In text the **heading** is the name in words, or
//! what [`Rows::head`] says, and the unit; numbers have the digits asked for. JSON, CSV and Parquet keep every number exactly.
//!
//! Every column that is written to a file has a **meaning**: Parquet carries it beside the unit, and `cohold recording columns` prints
//! both from the same declarations, made over no rows.
//!
//! | cell | text | JSON | CSV | Parquet |
//! |---|---|---|---|---|
//! | nothing | `-` | null | empty | null |
//! | yes or no | `yes`, `NO` | true, false | 1, 0 | BOOLEAN |
//! | count | its digits | exact | all digits | INT64 |
//! | number | its digits | exact, null for NaN | shortest that reads back | DOUBLE |
//! | list of numbers | with commas | array | with blanks | text |
//! | text | itself | string | string | text |
//!
//! **What a column holds** ([`Holds`]) follows from what it was declared of, and not from what stands in it: a column of reasons is
//! one of texts also where nothing failed. A run over time, whose rows are numbers, has it from the column's name, as the unit: `mode` is a count
//! and `live` a flag.
//!
//! In text a column whose filled cells are all numbers is set to the right, any other to the left. Widths count
//! characters, so wide scripts and combining marks are not aligned.
#![forbid(unsafe_code)]

mod cell;
mod rows;
mod unit;
mod value;

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt;

use cohold_io::{escaped, significant};
use serde::{Serialize, Serializer};
use serde_json::Value;

use unit::{holds, split_unit};
use value::{fields, within};

pub use cell::{Cell, Holds, Typed};
pub use rows::Rows;
pub use unit::{label, numbered};
pub use value::word;

/// How a number is written in text.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Digits {
    /// As many as it takes.
    All,
    /// This many digits behind the point.
    Fixed(usize),
    /// At least so many that count.
    Significant(usize),
    /// A mantissa with this many digits behind the point, and a power of ten.
    Power(usize),
    Signed,
    /// As many as it takes where those are few, else six that count.
    Short,
}

impl Digits {
    fn write(self, number: f64) -> String {
        match self {
            Self::All => number.to_string(),
            Self::Fixed(digits) => format!("{number:.digits$}"),
            Self::Significant(digits) => significant(number, digits),
            Self::Power(digits) => format!("{number:.digits$e}"),
            Self::Signed => format!("{number:+}"),
            Self::Short => Some(number.to_string()).filter(|all| all.len() < 7).unwrap_or(significant(number, 6)),
        }
    }
}

/// What stands in a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Numbers and nothing else.
    Numbers(Vec<f64>),
    /// Cells of this sort, or nothing.
    Cells(Holds, Vec<Cell>),
}

impl Values {
    /// What stands in this row; nothing where there is no such row.
    /// The cell of a row, from 0.
    pub fn cell(&self, row: usize) -> Cell {
        match self {
            Self::Numbers(values) => values.get(row).copied().into(),
            Self::Cells(_, values) => values.get(row).cloned().unwrap_or(Cell::Empty),
        }
    }
}

/// One column: name, unit, meaning and values.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    name: String,
    head: String,
    unit: String,
    meaning: String,
    scale: f64,
    digits: Digits,
    in_text: bool,
    /// Rows whose text is a dash, whatever the number.
    blank: Vec<bool>,
    values: Values,
}

impl Column {
    fn new(name: String, digits: Digits, values: Values) -> Self {
        let (head, unit) = split_unit(&name);
        Self {
            head: head.replace(['_', '.'], " "),
            unit: unit.to_owned(),
            meaning: String::new(),
            scale: 1.0,
            in_text: true,
            blank: Vec::new(),
            name,
            digits,
            values,
        }
    }

    /// A column of numbers, and what it means.
    pub fn numbers(name: impl Into<String>, meaning: impl Into<String>, values: Vec<f64>) -> Self {
        Self { meaning: meaning.into(), ..Self::new(name.into(), Digits::All, Values::Numbers(values)) }
    }

    /// Its name, with the unit at the end.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The unit of what is written to files; empty of what has none: a count, a ratio, a flag, words.
    pub fn unit(&self) -> &'static str {
        split_unit(&self.name).1
    }

    /// Meaning of the column, in words; may be empty.
    pub fn meaning(&self) -> &str {
        &self.meaning
    }

    /// Name and values as they are written to files, given away.
    pub fn into_parts(self) -> (String, Values) {
        match self.typed() {
            Cow::Owned(values) => (self.name, values),
            Cow::Borrowed(_) => (self.name, self.values),
        }
    }

    /// What is written to files: numbers as cells of what the name says.
    pub fn typed(&self) -> Cow<'_, Values> {
        let holds = holds(&self.name);
        let (Values::Numbers(numbers), Holds::Flags | Holds::Counts) = (&self.values, holds) else {
            return Cow::Borrowed(&self.values);
        };
        let cell = |number: &f64| match holds {
            _ if number.is_nan() => Cell::Empty,
            Holds::Flags if [0.0, 1.0].contains(number) => Cell::Flag(*number == 1.0),
            Holds::Counts if *number as i64 as f64 == *number => Cell::Whole(*number as i64),
            // Of somebody else's: it is as it is in CSV, and Parquet refuses it.
            _ => Cell::Number(*number),
        };
        Cow::Owned(Values::Cells(holds, numbers.iter().map(cell).collect()))
    }

    fn len(&self) -> usize {
        match &self.values {
            Values::Numbers(values) => values.len(),
            Values::Cells(_, values) => values.len(),
        }
    }

    /// What stands in this row; nothing where there is no such row.
    pub fn cell(&self, row: usize) -> Cell {
        self.values.cell(row)
    }

    fn heading(&self) -> String {
        format!("{} {}", self.head, self.unit).trim().to_owned()
    }

    fn text(&self, row: usize) -> String {
        if self.blank.get(row) == Some(&true) {
            return "-".to_owned();
        }
        let number = |number: f64| self.digits.write(self.scale * number);
        match self.cell(row) {
            Cell::Empty => "-".to_owned(),
            Cell::Flag(flag) => if flag { "yes" } else { "NO" }.to_owned(),
            Cell::Whole(count) if self.scale == 1.0 && self.digits == Digits::Signed => format!("{count:+}"),
            Cell::Whole(count) if self.scale == 1.0 => count.to_string(),
            Cell::Whole(count) => number(count as f64),
            Cell::Number(value) => number(value),
            Cell::List(values) => values.into_iter().map(number).collect::<Vec<_>>().join(", "),
            Cell::Text(text) => escaped(&text).into_owned(),
        }
    }
}

/// Columns of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    columns: Vec<Column>,
}

impl Columns {
    /// Columns of these rows, to be declared one by one.
    pub fn of<R>(rows: &[R]) -> Rows<'_, R> {
        Rows { rows, columns: Self::default() }
    }

    /// Columns of documents, an object each: a column for every field that is filled anywhere, in the order of their coming; one of
    /// an object within is called by both names, with a dot between. It holds what its first filled cell is: nothing declares it.
    pub fn of_documents(documents: &[Value]) -> Self {
        let rows: Vec<Vec<(String, Cell)>> = documents.iter().map(|document| fields("", document)).collect();
        let mut names: Vec<&String> = Vec::new();
        for (name, _) in rows.iter().flatten().filter(|(_, cell)| *cell != Cell::Empty) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let cell = |row: &Vec<(String, Cell)>, wanted: &String| {
            row.iter().find(|(name, _)| name == wanted).map_or(Cell::Empty, |(_, cell)| cell.clone())
        };
        let cells = |name: &String| {
            let cells: Vec<Cell> = rows.iter().map(|row| cell(row, name)).collect();
            Values::Cells(cells.iter().find_map(Cell::is).unwrap_or(Holds::Texts), cells)
        };
        let column = |name: &String| Column::new(name.clone(), Digits::Short, cells(name));
        Self { columns: names.into_iter().map(column).collect() }
    }

    /// Columns of numbers without rows yet, by name and meaning, to be filled with [`Self::push_row`].
    pub fn named<N: Into<String>, M: Into<String>>(columns: impl IntoIterator<Item = (N, M)>) -> Self {
        let column = |(name, meaning)| Column::numbers(name, meaning, Vec::new());
        Self { columns: columns.into_iter().map(column).collect() }
    }

    /// These columns without the one of this name.
    #[must_use]
    pub fn without(mut self, name: &str) -> Self {
        self.columns.retain(|column| column.name != name);
        self
    }

    /// One column more, cell by cell. Not generic: compiled once and not for each of hundreds of columns.
    fn declare(&mut self, name: String, digits: Digits, holds: Holds, rows: usize, cell: &dyn Fn(usize) -> Cell) {
        self.push(Column::new(name, digits, Values::Cells(holds, (0..rows).map(cell).collect())));
    }

    /// One column more.
    ///
    /// # Panics
    /// It is longer or shorter than the others.
    pub fn push(&mut self, column: Column) {
        assert!(self.columns.is_empty() || column.len() == self.len(), "column `{}` has other rows", column.name);
        self.columns.push(column);
    }

    /// Adds one row of numbers, one for each column.
    ///
    /// # Panics
    /// The row has another number of values than there are columns, or a column is none of numbers.
    pub fn push_row(&mut self, row: &[f64]) {
        assert_eq!(row.len(), self.columns.len(), "a row has one value for each column");
        for (column, value) in self.columns.iter_mut().zip(row) {
            match &mut column.values {
                Values::Numbers(values) => values.push(*value),
                Values::Cells(..) => panic!("column `{}` is none of numbers", column.name),
            }
        }
    }

    /// Columns that are written to files, in their order.
    pub fn data(&self) -> impl Iterator<Item = &Column> + Clone {
        self.columns.iter()
    }

    /// The same, each with a name of its own.
    ///
    /// # Errors
    /// Two columns have one name; in a sentence.
    pub fn distinct(&self) -> Result<Vec<&Column>, String> {
        let mut names = BTreeSet::new();
        match self.data().find(|column| !names.insert(column.name())) {
            Some(column) => {
                Err(format!("two columns are named `{}`: every column needs a name of its own", column.name()))
            }
            None => Ok(self.data().collect()),
        }
    }

    /// The values of the column of numbers with exactly this name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let column = self.columns.iter().find(|column| column.name == name)?;
        match &column.values {
            Values::Numbers(values) => Some(values),
            Values::Cells(..) => None,
        }
    }

    /// The points of a curve: a column of numbers, times `scale`, over another; none where either is missing.
    pub fn points(&self, x: &str, y: &str, scale: f64) -> Vec<(f64, f64)> {
        let [x, y] = [x, y].map(|name| self.column(name).unwrap_or_default());
        x.iter().zip(y).map(|(x, y)| (*x, scale * y)).collect()
    }

    /// One row as an object; a dot in a name is an object within, or a list where what follows is a number.
    pub fn row(&self, row: usize) -> Value {
        let mut object = Value::Null;
        for column in &self.columns {
            let place = column.name.split('.').fold(&mut object, within);
            *place = column.cell(row).into();
        }
        object
    }

    /// Number of rows in each column.
    pub fn len(&self) -> usize {
        self.columns.first().map_or(0, Column::len)
    }

    /// True when there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn shown(&self) -> impl Iterator<Item = &Column> {
        self.columns.iter().filter(|column| column.in_text)
    }

    /// Headings, and the texts of every row.
    fn grid(&self) -> Vec<Vec<String>> {
        let rows = (0..self.len()).map(|row| self.shown().map(|column| column.text(row)).collect());
        std::iter::once(self.shown().map(Column::heading).collect()).chain(rows).collect()
    }

    /// As text with a line for every column and `titles` above the rows, which stand side by side; a column in which
    /// there is nothing is left out. For one row, or few, of many columns.
    pub fn down(&self, titles: &[&str]) -> String {
        let titles = std::iter::once("").chain(titles.iter().copied()).map(str::to_owned).collect();
        let lines = self.shown().filter(|column| (0..self.len()).any(|row| column.text(row) != "-")).map(|column| {
            let with_unit = |row| match column.text(row) {
                dash if dash == "-" => dash,
                text => format!("{text} {}", column.unit).trim_end().to_owned(),
            };
            std::iter::once(column.head.clone()).chain((0..self.len()).map(with_unit)).collect()
        });
        aligned(&std::iter::once(titles).chain(lines).collect::<Vec<_>>())
    }

    /// A line for each of these columns: its heading and what it means.
    pub fn meanings(&self, names: &[&str]) -> String {
        let described = self.shown().filter(|column| names.contains(&column.name()));
        described.map(|column| format!("{}: {}.\n", column.head, column.meaning)).collect()
    }
}

/// The columns one by one.
impl IntoIterator for Columns {
    type Item = Column;
    type IntoIter = std::vec::IntoIter<Column>;

    fn into_iter(self) -> Self::IntoIter {
        self.columns.into_iter()
    }
}

impl fmt::Display for Columns {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&aligned(&self.grid()))
    }
}

/// The rows of a grid with aligned columns, those of numbers to the right, and a rule below the first.
fn aligned(grid: &[Vec<String>]) -> String {
    let number = |cell: &String| {
        let cell = cell.trim_end_matches('%').trim();
        cell == "-" || cell.parse::<f64>().is_ok()
    };
    let column = |at: usize| {
        let width = grid.iter().filter_map(|row| row.get(at)).map(|cell| cell.chars().count()).max().unwrap_or(0);
        let mut filled = grid.iter().skip(1).filter_map(|row| row.get(at)).filter(|cell| !cell.is_empty()).peekable();
        (width, filled.peek().is_some() && filled.all(number))
    };
    let layout: Vec<_> = (0..grid.iter().map(Vec::len).max().unwrap_or(0)).map(column).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&layout).map(|(cell, (width, right))| match right {
            true => format!("{cell:>width$}"),
            false => format!("{cell:<width$}"),
        });
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n"
    };
    let rule = layout.iter().map(|(width, _)| "-".repeat(*width)).collect::<Vec<_>>().join("  ");
    let mut lines = grid.iter().map(line);
    let head = lines.next().unwrap_or_default();
    format!("{head}{rule}\n{}", lines.collect::<String>())
}

impl Serialize for Columns {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq((0..self.len()).map(|row| self.row(row)))
    }
}
