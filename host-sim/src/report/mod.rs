//! Reports: what an experiment found, as files that people and other programs can read.
//!
//! | file | gives |
//! |---|---|
//! | `table` | named columns of equal length, the unit in the name |
//! | `files` | a table as CSV or Parquet |
//! | `plot` | a declared figure as SVG and PNG |
//! | `text` | aligned text and Markdown tables for the terminal and the documents |
//! | `error` | what can go wrong, with the path and the cause |
//!
//! Nothing here knows about haptics. The same data give the same bytes on every run: no clock, no system font, no map
//! with a random order. Empty tables, NaN and constant data are ordinary input everywhere.

mod error;
pub mod files;
pub mod plot;
#[cfg(test)]
mod scratch;
pub mod table;
pub mod text;

pub use error::ReportError;
