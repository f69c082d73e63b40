//! Reports: what an experiment found, as files that people and other programs can read.
//!
//! Nothing here knows about haptics. The same data give the same bytes on every run, but for the record of when and by
//! which program they were made: no system font, no map with a random order. Empty tables, NaN and constant data are
//! ordinary input everywhere.
#![forbid(unsafe_code)]

pub mod files;
mod parquet_file;

pub use cohold_columns::{Cell, Column, Columns, Holds, Rows, Typed, Values, label, numbered, word};
pub use cohold_plot::{Error, significant};
pub use files::{Files, Provenance};
pub use parquet_file::ROW_GROUP_ROWS;
