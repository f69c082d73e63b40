//! What can go wrong while a report is written.
//!
//! One enum for the room: each sentence names the path or the column, and the cause.

use std::path::{Path, PathBuf};

/// Why a table was refused or a report file could not be written.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A column is shorter or longer than the first one.
    #[error("column `{name}` has {found} values where the first column has {expected}")]
    ColumnLength {
        /// The column at fault.
        name: String,
        /// Its number of values.
        found: usize,
        /// The number of values of the first column.
        expected: usize,
    },
    /// Two columns share one name.
    #[error("two columns are named `{name}`: every column needs a name of its own")]
    DuplicateColumn {
        /// The name that occurs twice.
        name: String,
    },
    /// A row does not have one value for each column.
    #[error("a row of {found} values does not fit a table of {expected} columns")]
    RowWidth {
        /// The number of values in the row.
        found: usize,
        /// The number of columns of the table.
        expected: usize,
    },
    /// A file could not be written.
    #[error("cannot write {} as {format}: {cause}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What it was to contain: `CSV`, `Parquet`, `SVG` or `PNG`.
        format: &'static str,
        /// What the operating system or the encoder said.
        cause: String,
    },
}

impl ReportError {
    /// The error of writing `path` as `format`, for `map_err`.
    /// What a failed write of `path` as `format` becomes.
    pub fn write<E: std::fmt::Display>(path: &Path, format: &'static str) -> impl Fn(E) -> Self {
        move |cause| Self::Write { path: path.to_owned(), format, cause: cause.to_string() }
    }
}
