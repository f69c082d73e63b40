//! The columns that `cohold recording columns` tells of, for every test that looks at a table.

use std::path::Path;

use serde_json::Value;

use crate::program::{cohold, report};

/// The columns of a kind of table, as `cohold recording columns` says: name, unit and meaning.
pub(crate) fn declared(kind: &str) -> Vec<[String; 3]> {
    let told = report(cohold(&["recording", "columns", kind, "--json"]).spawn().expect("cohold runs"));
    let columns = told[kind]["columns"].as_array().expect("columns");
    let text = |column: &Value, field: &str| column[field].as_str().unwrap_or_default().to_owned();
    columns.iter().map(|column| ["column", "unit", "meaning"].map(|field| text(column, field))).collect()
}

/// This CSV file has just the columns of its kind, in their order.
pub(crate) fn has_columns_of(kind: &str, file: &Path) {
    let text = std::fs::read_to_string(file).unwrap_or_else(|cause| panic!("{}: {cause}", file.display()));
    let names: Vec<String> = declared(kind).into_iter().map(|[name, ..]| name).collect();
    assert_eq!(text.lines().next().unwrap_or_default().split(',').collect::<Vec<_>>(), names, "{kind}");
}
