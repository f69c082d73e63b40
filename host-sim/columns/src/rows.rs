//! Columns as they are declared over rows.

use super::{Cell, Column, Columns, Digits, Holds, Typed};

/// Columns of a slice of rows, being declared. What is said of a column is said of the last one.
#[must_use]
#[derive(Debug)]
pub struct Rows<'a, R> {
    pub(super) rows: &'a [R],
    pub(super) columns: Columns,
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

    /// A column of files alone: text tables leave it out.
    pub fn data<C: Typed>(self, name: impl Into<String>, cell: impl Fn(&'a R) -> C) -> Self {
        self.value(name, cell).data_only()
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
