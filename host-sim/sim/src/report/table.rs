//! A table: named columns of equal length.
//!
//! Every value is an `f64`; the unit is the last part of the column's name (`time_s`, `object_1_m`, `force_n`), so that
//! a file needs no second file to be understood. Two things always hold: all columns are equally long, and no name
//! occurs twice. NaN and infinities are allowed and mean themselves.

use super::ReportError;

/// One named column.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Name with its unit as suffix, for example `object_1_m`.
    pub name: String,
    /// The values, first row first.
    pub values: Vec<f64>,
}

impl Column {
    /// A column of these values.
    pub fn new(name: impl Into<String>, values: Vec<f64>) -> Self {
        Self { name: name.into(), values }
    }
}

/// Columns of equal length with distinct names.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    columns: Vec<Column>,
}

impl Table {
    /// A table of these columns, if they are equally long and named differently.
    pub fn new(columns: Vec<Column>) -> Result<Self, ReportError> {
        let expected = columns.first().map_or(0, |c| c.values.len());
        for (i, column) in columns.iter().enumerate() {
            if column.values.len() != expected {
                let (name, found) = (column.name.clone(), column.values.len());
                return Err(ReportError::ColumnLength { name, found, expected });
            }
            if columns.iter().take(i).any(|c| c.name == column.name) {
                return Err(ReportError::DuplicateColumn { name: column.name.clone() });
            }
        }
        Ok(Self { columns })
    }

    /// A table with these columns and no rows yet, to be filled with [`Table::push_row`].
    pub fn with_names(names: &[&str]) -> Result<Self, ReportError> {
        Self::new(names.iter().map(|name| Column::new(*name, Vec::new())).collect())
    }

    /// Adds one row: one value for each column, in their order.
    pub fn push_row(&mut self, row: &[f64]) -> Result<(), ReportError> {
        if row.len() != self.columns.len() {
            return Err(ReportError::RowWidth { found: row.len(), expected: self.columns.len() });
        }
        for (column, value) in self.columns.iter_mut().zip(row) {
            column.values.push(*value);
        }
        Ok(())
    }

    /// The columns, in their order.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The values of the column with exactly this name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.columns.iter().find(|c| c.name == name).map(|c| c.values.as_slice())
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.columns.first().map_or(0, |c| c.values.len())
    }

    /// True when there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_must_be_equally_long() {
        let error = Table::new(vec![Column::new("time_s", vec![0.0, 1.0]), Column::new("x_m", vec![0.0])]).unwrap_err();
        assert_eq!(error.to_string(), "column `x_m` has 1 values where the first column has 2");
    }

    #[test]
    fn names_must_differ() {
        let error = Table::with_names(&["x_m", "y_m", "x_m"]).unwrap_err();
        assert_eq!(error.to_string(), "two columns are named `x_m`: every column needs a name of its own");
    }

    #[test]
    fn rows_fill_columns_and_must_fit() {
        let mut table = Table::with_names(&["time_s", "x_m"]).unwrap();
        assert!(table.is_empty());
        table.push_row(&[0.0, 1.5]).unwrap();
        table.push_row(&[1.0, f64::NAN]).unwrap();
        assert_eq!(table.len(), 2);
        assert_eq!(table.column("time_s"), Some(&[0.0, 1.0][..]));
        assert_eq!(table.column("z_m"), None);
        assert!(table.push_row(&[1.0]).unwrap_err().to_string().contains("row of 1 values"));
        assert_eq!(table.len(), 2);
    }

    #[test]
    fn a_table_without_columns_is_empty() {
        assert_eq!(Table::new(Vec::new()).unwrap().len(), 0);
    }
}
