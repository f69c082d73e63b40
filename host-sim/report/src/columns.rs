//! Columns: what a table holds, declared once, as aligned text, CSV, Parquet and JSON.
//!
//! A study declares its columns over a slice of its rows; name, digits and meaning stand in one place:
//!
//! ```
//! use haptic_report::Columns;
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
//! Every column that is written to a file has a **meaning**: Parquet carries it beside the unit, and `host-sim columns` prints
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
//! one of texts also where nothing failed.
//!
//! In text a column whose filled cells are all numbers is set to the right, any other to the left. Widths count
//! characters, so wide scripts and combining marks are not aligned.

use std::fmt;

use haptic_io::escaped;
use haptic_plot::significant;
use serde::{Serialize, Serializer};
use serde_json::Value;

/// What stands at one place of a table.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(into = "Value")]
pub enum Cell {
    /// No value: it was not measured, or there is none.
    Empty,
    /// A switch: true or false.
    Flag(bool),
    /// A whole number, such as a count.
    Whole(i64),
    /// A number, in the column's unit.
    Number(f64),
    /// Several numbers, in the column's unit.
    List(Vec<f64>),
    /// Text, such as a name.
    Text(String),
}

/// What the filled cells of a column are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holds {
    /// Yes or no.
    Flags,
    /// Whole numbers.
    Counts,
    /// Numbers.
    Numbers,
    /// Several numbers each.
    Lists,
    /// Texts.
    Texts,
}

impl Cell {
    /// What a column of such cells holds; nothing of an empty one.
    pub fn is(&self) -> Option<Holds> {
        match self {
            Self::Empty => None,
            Self::Flag(_) => Some(Holds::Flags),
            Self::Whole(_) => Some(Holds::Counts),
            Self::Number(_) => Some(Holds::Numbers),
            Self::List(_) => Some(Holds::Lists),
            Self::Text(_) => Some(Holds::Texts),
        }
    }
}

/// What makes cells that are all of one sort.
pub trait Typed: Into<Cell> {
    /// Which that is.
    const HOLDS: Holds;
}

macro_rules! cell_from {
    ($($from:ty => $holds:ident $cell:expr),+ $(,)?) => {
        $(impl From<$from> for Cell {
            fn from(value: $from) -> Self {
                $cell(value)
            }
        }

        impl Typed for $from {
            const HOLDS: Holds = Holds::$holds;
        })+
    };
}

cell_from! {
    bool => Flags Cell::Flag,
    f64 => Numbers Cell::Number,
    f32 => Numbers |value| Cell::Number(f64::from(value)),
    u8 => Counts |value| Cell::Whole(i64::from(value)),
    u16 => Counts |value| Cell::Whole(i64::from(value)),
    u32 => Counts |value| Cell::Whole(i64::from(value)),
    i32 => Counts |value| Cell::Whole(i64::from(value)),
    i64 => Counts Cell::Whole,
    u64 => Counts |value| i64::try_from(value).map_or(Cell::Number(value as f64), Cell::Whole),
    usize => Counts |value| Cell::from(value as u64),
    Vec<f64> => Lists Cell::List,
    String => Texts Cell::Text,
    &str => Texts |value: &str| Cell::Text(value.to_owned()),
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Empty, Into::into)
    }
}

impl<T: Typed> Typed for Option<T> {
    const HOLDS: Holds = T::HOLDS;
}

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

/// Units by the ends of names, the longer one first where one ends like the other.
const UNITS: &[(&str, &str)] = &[
    ("counts_per_m", "counts/m"),
    ("bytes_per_s", "B/s"),
    ("bit_per_s", "bit/s"),
    ("mm_per_n", "mm/N"),
    ("n_s_per_m", "N·s/m"),
    ("n_per_m", "N/m"),
    ("m_per_s", "m/s"),
    ("per_s", "/s"),
    ("n_s", "N·s"),
    ("percent", "percent"),
    ("rad", "rad"),
    ("deg", "deg"),
    ("ppm", "ppm"),
    ("khz", "kHz"),
    ("hz", "Hz"),
    ("kg", "kg"),
    ("mm", "mm"),
    ("um", "µm"),
    ("ms", "ms"),
    ("us", "µs"),
    ("mn", "mN"),
    ("mj", "mJ"),
    ("m", "m"),
    ("s", "s"),
    ("n", "N"),
    ("j", "J"),
    ("v", "V"),
];

/// A name without its unit, and the unit: at the end, or before a dot (`force_n.mean`).
fn split_unit(name: &str) -> (String, &'static str) {
    let without = |part: &str| {
        let of = |(end, unit): &(&str, &'static str)| Some((part.strip_suffix(end)?.strip_suffix(['_', '.'])?, *unit));
        let (rest, unit) = UNITS.iter().find_map(of).filter(|(rest, _)| !rest.is_empty())?;
        Some((rest.to_owned() + &name[part.len()..], unit))
    };
    let ends = std::iter::once(name.len()).chain(name.rmatch_indices('.').map(|(dot, _)| dot));
    ends.map(|end| &name[..end]).find_map(without).unwrap_or_else(|| (name.to_owned(), ""))
}

/// The name of what there is several of, with a number before its unit: `object_m` of peer 2 is `object_2_m`.
pub fn numbered(name: &str, number: usize) -> String {
    let (rest, _) = split_unit(name);
    format!("{rest}_{number}{}", &name[rest.len()..])
}

/// What a name is called on an axis, with its unit: `coordination.stiffness_n_per_m` is `Stiffness (N/m)`.
pub fn label(name: &str) -> String {
    let (rest, unit) = split_unit(name.rsplit('.').next().unwrap_or(name));
    let rest = rest.replace('_', " ");
    let mut letters = rest.chars();
    let first = letters.next().map(|letter| letter.to_uppercase().to_string()).unwrap_or_default();
    let unit = if unit.is_empty() { String::new() } else { format!(" ({unit})") };
    format!("{first}{}{unit}", letters.as_str())
}

/// What stands in a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Numbers and nothing else.
    Numbers(Vec<f64>),
    /// Cells of this sort, or nothing.
    Cells(Holds, Vec<Cell>),
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

    /// What it is filled with.
    pub fn values(&self) -> &Values {
        &self.values
    }

    /// Name and values, given away.
    pub fn into_parts(self) -> (String, Values) {
        (self.name, self.values)
    }

    fn len(&self) -> usize {
        match &self.values {
            Values::Numbers(values) => values.len(),
            Values::Cells(_, values) => values.len(),
        }
    }

    /// What stands in this row; nothing where there is no such row.
    pub fn cell(&self, row: usize) -> Cell {
        match &self.values {
            Values::Numbers(values) => values.get(row).copied().into(),
            Values::Cells(_, values) => values.get(row).cloned().unwrap_or(Cell::Empty),
        }
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

/// Columns of a slice of rows, being declared. What is said of a column is said of the last one.
#[must_use]
#[derive(Debug)]
pub struct Rows<'a, R> {
    rows: &'a [R],
    columns: Columns,
}

impl<'a, R> Rows<'a, R> {
    fn with<C: Typed>(self, name: impl Into<String>, digits: Digits, cell: impl Fn(&'a R) -> C) -> Self {
        self.declare(name.into(), digits, C::HOLDS, &|row| cell(row).into())
    }

    fn declare(mut self, name: String, digits: Digits, holds: Holds, cell: &dyn Fn(&'a R) -> Cell) -> Self {
        let rows = self.rows;
        self.columns.declare(name, digits, holds, rows.len(), &|row| cell(&rows[row]));
        self
    }

    fn last(mut self, change: impl FnOnce(&mut Column)) -> Self {
        if let Some(column) = self.columns.columns.last_mut() {
            change(column);
        }
        self
    }

    /// A column of texts, flags, counts, or numbers with as many digits as they have.
    pub fn value<C: Typed>(self, name: impl Into<String>, cell: impl Fn(&'a R) -> C) -> Self {
        self.with(name, Digits::All, cell)
    }

    /// A column whose cells are made one by one, and what it holds.
    pub fn cells(self, name: impl Into<String>, holds: Holds, cell: impl Fn(&'a R) -> Cell) -> Self {
        self.declare(name.into(), Digits::All, holds, &cell)
    }

    /// A column of numbers with so many digits behind the point.
    pub fn number<C: Typed>(self, name: impl Into<String>, digits: usize, cell: impl Fn(&'a R) -> C) -> Self {
        self.with(name, Digits::Fixed(digits), cell)
    }

    /// A column of numbers with at least so many digits that count.
    pub fn significant<C: Typed>(self, name: impl Into<String>, digits: usize, cell: impl Fn(&'a R) -> C) -> Self {
        self.with(name, Digits::Significant(digits), cell)
    }

    /// A column of powers of ten with so many digits behind the point.
    pub fn power<C: Typed>(self, name: impl Into<String>, digits: usize, cell: impl Fn(&'a R) -> C) -> Self {
        self.with(name, Digits::Power(digits), cell)
    }

    /// A column of differences, always with a sign.
    pub fn signed<C: Typed>(self, name: impl Into<String>, cell: impl Fn(&'a R) -> C) -> Self {
        self.with(name, Digits::Signed, cell)
    }

    /// Heading of the column in text tables, without the unit.
    pub fn head(self, head: &str) -> Self {
        self.last(|column| column.head = head.to_owned())
    }

    /// In text, in this unit: `factor` of the name's one. The data keep the unit of the name.
    pub fn shown_in(self, unit: &str, factor: f64) -> Self {
        self.last(|column| (column.unit, column.scale) = (unit.to_owned(), factor))
    }

    /// Meaning of the column, for those who read the table or its file.
    pub fn means(self, meaning: &str) -> Self {
        self.last(|column| column.meaning = meaning.to_owned())
    }

    /// In text only rows of which this is true show it; the data keep all.
    pub fn where_true(self, shown: impl Fn(&R) -> bool) -> Self {
        let blank = self.rows.iter().map(|row| !shown(row)).collect();
        self.last(|column| column.blank = blank)
    }

    /// Leaves the last column out of text tables; files have it.
    pub fn data_only(self) -> Self {
        self.last(|column| column.in_text = false)
    }

    /// The columns as they were declared.
    pub fn done(self) -> Columns {
        self.columns
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

    /// The values of the column of numbers with exactly this name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.columns.iter().find(|column| column.name == name).and_then(|column| match &column.values {
            Values::Numbers(values) => Some(values.as_slice()),
            Values::Cells(..) => None,
        })
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

/// A value as a word, or several.
pub fn word(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(items) => items.iter().map(word).collect::<Vec<_>>().join("  "),
        _ => value.to_string(),
    }
}

/// The cells of a value, named: of an object each field, of a list of objects each of theirs, else the value itself; of a list of
/// lists how many there are.
fn fields(name: &str, value: &Value) -> Vec<(String, Cell)> {
    let within = |own: &str| [name, own].join(".").trim_start_matches('.').to_owned();
    let cell = match value {
        Value::Object(inner) => return inner.iter().flat_map(|(own, value)| fields(&within(own), value)).collect(),
        Value::Array(items) if items.iter().any(Value::is_object) => {
            return items.iter().enumerate().flat_map(|(at, item)| fields(&within(&at.to_string()), item)).collect();
        }
        Value::Array(items) => match items.iter().map(Value::as_f64).collect() {
            _ if items.is_empty() => Cell::Empty,
            Some(numbers) => Cell::List(numbers),
            None if items.iter().any(Value::is_array) => items.len().into(),
            None => Cell::Text(items.iter().map(word).collect::<Vec<_>>().join(", ")),
        },
        Value::Null => Cell::Empty,
        Value::Bool(flag) => (*flag).into(),
        Value::Number(number) => number.as_i64().map_or_else(|| number.as_f64().into(), Cell::Whole),
        Value::String(text) => text.as_str().into(),
    };
    vec![(name.to_owned(), cell)]
}

impl Serialize for Columns {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq((0..self.len()).map(|row| self.row(row)))
    }
}

/// What is called so within a value, which is made an object for it, or a list for a number that counts from 0.
fn within<'a>(at: &'a mut Value, name: &str) -> &'a mut Value {
    let in_list = |index: &usize| match &*at {
        Value::Null => *index == 0,
        Value::Array(items) => *index <= items.len(),
        _ => false,
    };
    let Some(index) = name.parse::<usize>().ok().filter(in_list) else { return &mut at[name] };
    if at.is_null() {
        *at = Value::Array(Vec::new());
    }
    if let Value::Array(items) = at
        && items.len() == index
    {
        items.push(Value::Null);
    }
    &mut at[index]
}

impl From<Cell> for Value {
    fn from(cell: Cell) -> Self {
        match cell {
            Cell::Empty => Self::Null,
            Cell::Flag(flag) => flag.into(),
            Cell::Whole(count) => count.into(),
            Cell::Number(number) => number.into(),
            Cell::List(numbers) => numbers.into(),
            Cell::Text(text) => text.into(),
        }
    }
}
